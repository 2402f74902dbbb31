"""From voltages and forces to what the microcontroller sends.

Integer arithmetic throughout, so that firmware can give the same bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from firstcontact.core.layout import (
    ADC_COUNTS,
    ADC_VOLTS,
    PIEZO_OFFSET_VOLTS,
    SUBCOUNTS,
    TAXELS,
)

#: Readings of a taxel that the sliding mean covers.
FORCE_READINGS = 8


class VelostatParameters(NamedTuple):
    """One fingertip's force array. SI units."""

    threshold: float = 0.30
    """Force on a taxel below which the sheet does not conduct better, N."""
    rise: float = 0.030
    """Time constant when loaded, s."""
    fall: float = 0.060
    """Time constant when unloaded: the hysteresis, s."""
    creep_share: float = 0.15
    """Share of the response that comes late."""
    creep: float = 0.4
    """Time constant of that share, s."""
    conductance: float = 2.2e-4
    """Gain, S / N^0.85."""
    exponent: float = 0.85
    leak: float = 2.0e-5
    """Conductance unloaded, S."""
    resistor: float = 4700.0
    """Of the divider, ohm."""
    crosstalk: float = 0.04
    """Share of its row neighbour's conductance that a reading sees."""
    noise: float = 0.004
    """RMS at the converter, V."""


@njit(cache=True, nogil=True)
def piezo_counts(volts: NDArray[np.float64]) -> NDArray[np.int16]:
    """Convert and smooth the piezo as the microcontroller does.

    Parameters
    ----------
    volts
        At the converter's input, without the 1.65 V offset, shape (samples,).

    Returns
    -------
    ndarray
        1/32 ADC counts; y += (x - y) / 2 in integers, rounding down: exponential
        smoothing with alpha = 0.5.
    """
    out = np.empty(volts.size, np.int16)
    y = -1
    for i in range(volts.size):
        count = int(np.floor((volts[i] + PIEZO_OFFSET_VOLTS) * (ADC_COUNTS / ADC_VOLTS)))
        x = min(max(count, 0), ADC_COUNTS - 1) * SUBCOUNTS
        y = x if y < 0 else (y + x) >> 1
        out[i] = y
    return out


@njit(cache=True, nogil=True)
def force_counts(
    force: NDArray[np.float64],
    shares: NDArray[np.float64],
    p: VelostatParameters,
    noise: NDArray[np.float64],
    dt: float,
) -> NDArray[np.int16]:
    """Read one force array: one taxel a sample, row by row, each under a sliding mean.

    Parameters
    ----------
    force
        Total force on the array, N, shape (samples,).
    shares
        Share of it on each taxel, shape (6,).
    p
        The sheet and its divider.
    noise
        At the converter, V, shape (samples,).
    dt
        Sampling interval, s.

    Returns
    -------
    ndarray
        1/32 ADC counts, shape (samples, 6).
    """
    out = np.empty((force.size, TAXELS), np.int16)
    quick = np.zeros(TAXELS)
    late = np.zeros(TAXELS)
    # The device has been reading the unloaded sheet before the first sample.
    open_hand = _divider_count(p, p.leak, p.leak, 0.0)
    readings = np.full((TAXELS, FORCE_READINGS), open_hand)
    taken = 0
    for i in range(force.size):
        for k in range(TAXELS):
            load = max(force[i] * shares[k] - p.threshold, 0.0)
            tau = p.rise if load > quick[k] else p.fall
            quick[k] += (load - quick[k]) * dt / tau
            late[k] += (load - late[k]) * dt / p.creep
        taxel = i % TAXELS
        # Row neighbours: taxels 2r and 2r + 1 share a row.
        neighbour = taxel + 1 if taxel % 2 == 0 else taxel - 1
        readings[taxel, taken] = _divider_count(
            p,
            _conductance(p, quick[taxel], late[taxel]),
            _conductance(p, quick[neighbour], late[neighbour]),
            noise[i],
        )
        if taxel == TAXELS - 1:
            taken = (taken + 1) % FORCE_READINGS
        for k in range(TAXELS):
            out[i, k] = readings[k].sum() * (SUBCOUNTS // FORCE_READINGS)
    return out


@njit(cache=True, nogil=True)
def _conductance(p: VelostatParameters, quick: float, late: float) -> float:
    """Of a taxel, S, from the two parts of its response (N)."""
    felt = (1.0 - p.creep_share) * quick + p.creep_share * late
    return p.leak + p.conductance * float(felt**p.exponent)


@njit(cache=True, nogil=True)
def _divider_count(p: VelostatParameters, own: float, neighbour: float, noise: float) -> int:
    """ADC count of a taxel read through the divider, for conductances in S and noise in V."""
    g = own + p.crosstalk * neighbour
    volts = ADC_VOLTS * p.resistor * g / (1.0 + p.resistor * g) + noise
    return min(max(int(np.floor(volts * (ADC_COUNTS / ADC_VOLTS))), 0), ADC_COUNTS - 1)
