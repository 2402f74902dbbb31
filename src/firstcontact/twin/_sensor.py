"""Raw counts of the fingertips' converters, before the microcontroller's filters.

One scan is six readings at one time: both piezos, one taxel of each force array, both strips.
:mod:`firstcontact.twin._filter` processes them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import TAXELS, kernels

#: Columns of a scan, uint16.
SCAN = ("piezo_index", "piezo_thumb", "force_index", "force_thumb", "strip_index", "strip_thumb")
_kernels = kernels()


class VelostatParameters(NamedTuple):
    """Parameters of one fingertip's force array. SI units."""

    threshold: float = 0.30
    """Force on a taxel up to which the conductance does not rise, N."""
    rise: float = 0.030
    """Time constant of the response when the load rises, s."""
    fall: float = 0.060
    """Time constant of the response when the load falls (hysteresis), s."""
    creep_share: float = 0.15
    """Share of the response that is slow."""
    creep: float = 0.4
    """Time constant of the slow response, s."""
    conductance: float = 2.2e-4
    """Conductance at a response of 1 N, in S / N^0.85."""
    exponent: float = 0.85
    leak: float = 2.0e-5
    """Conductance of an unloaded taxel, S."""
    resistor: float = 4700.0
    """Resistor of the divider, ohm."""
    crosstalk: float = 0.04
    """Share of the conductance of the neighbour in the same row that a reading includes."""
    noise: float = 0.004
    """RMS of the noise at the converter, V."""


#: Ideal force array, better than any real one: sensitive, fast and without creep.
OPTIMISTIC = VelostatParameters(threshold=0.0, rise=0.005, fall=0.010, creep_share=0.0)


def piezo_readings(volts: NDArray[np.float64]) -> NDArray[np.uint16]:
    """Convert the piezo's voltage into ADC counts."""
    out = np.empty(volts.size, np.uint16)
    _kernels.piezo_counts(np.ascontiguousarray(volts), out)
    return out


def force_readings(
    force: NDArray[np.float64],
    shares: NDArray[np.float64],
    p: VelostatParameters,
    noise: NDArray[np.float64],
    dt: float,
    state: NDArray[np.float64],
    first: int,
) -> NDArray[np.uint16]:
    """Return the readings of one force array: one taxel at each sample, row by row."""
    out = np.empty(force.size, np.uint16)
    _kernels.force_counts(
        np.ascontiguousarray(force), np.ascontiguousarray(shares), p,
        np.ascontiguousarray(noise), dt, state, first, out,
    )  # fmt: skip
    return out


def open_reading(p: VelostatParameters) -> int:
    """Return the ADC count of every taxel of an unloaded force array, without noise."""
    nothing, state = np.zeros(1), np.zeros((2, TAXELS))
    return int(force_readings(nothing, np.zeros(TAXELS), p, nothing, 1.0, state, 0)[0])
