"""Simulated electronics of a fingertip: converters, and filters of the microcontroller.

One scan is six readings at one time: both piezos, one taxel of each force array, both strips. The
filters use integer arithmetic, so that the firmware gives the same bits. The loops are compiled:
``twin/c/fingertips.c``.
"""

from __future__ import annotations

import copy
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Finger, fingertip_layout
from firstcontact.core.installation import load_compiled
from firstcontact.core.layout import FINGERTIP_RATE, TAXELS
from firstcontact.core.pinch import first_closed_sample
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.mechanics import BUFFER, CONTACT_FORCE, INDENTATION, VelostatParameters
from firstcontact.twin.noise import electrical_noise

_kernels = load_compiled("firstcontact.twin._compiled")

#: Columns of a scan, uint16.
SCAN = ("piezo_index", "piezo_thumb", "force_index", "force_thumb", "strip_index", "strip_thumb")


def piezo_readings(volts: NDArray[np.float64]) -> NDArray[np.uint16]:
    """Convert voltages of a piezo, V, into readings of the converter, counts."""
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
    """Convert the force on a finger, N, into readings of its force array, counts.

    Each sample reads one taxel (force cell). ``shares`` has the share of the force on each taxel,
    ``dt`` the time between samples, s, and ``first`` the number of the first sample. ``state`` is
    updated.
    """
    out = np.empty(force.size, np.uint16)
    _kernels.force_counts(
        np.ascontiguousarray(force), np.ascontiguousarray(shares), p,
        np.ascontiguousarray(noise), dt, state, first, out,
    )  # fmt: skip
    return out


def open_reading(p: VelostatParameters) -> int:
    """Return the reading of a force cell without load and noise, counts."""
    nothing, state = np.zeros(1), np.zeros((2, TAXELS))
    return int(force_readings(nothing, np.zeros(TAXELS), p, nothing, 1.0, state, 0)[0])


#: Number of readings of a taxel that the firmware averages.
FORCE_READINGS = 8
#: Number of scans after which every sliding mean holds new readings only.
ROUND = TAXELS * FORCE_READINGS
_COLUMNS = fingertip_layout().width


def smoothed(counts: NDArray[np.uint16]) -> NDArray[np.int16]:
    """Return the readings of one piezo after the device's exponential smoothing, 1/32 counts."""
    out = np.empty(counts.size, np.int16)
    _kernels.smooth(np.ascontiguousarray(counts), out)
    return out


class DeviceFilter:
    """Filters of the microcontroller, from its power-on, for blocks of any size.

    Piezo: exponential smoothing y = (y + x) >> 1 in 1/32 counts, with alpha = 0.5, rounded down.
    The first reading is the initial state.

    Force: sliding mean over the last 8 readings of each taxel, exact in 1/32 counts. The first
    reading of a taxel counts as 8 equal readings. A taxel without a reading is 0. Scan i reads
    taxel i modulo 6. The means are then corrected for the other taxels of the column, which share
    its divider: the sample is what the taxel would read alone, rounded to 1/32 count.

    A strip is 1 if its reading is not 0. Counts above 1023 are treated as 1023.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        # Position of the next scan in a cycle of ROUND scans, -1 before the first scan.
        self._place = np.full(1, -1, np.int64)
        self._smoothed = np.zeros(2, np.int64)
        self._readings = np.full((2, TAXELS, FORCE_READINGS), -1, np.int64)
        self._sums = np.zeros((2, TAXELS), np.int64)

    def fork(self) -> Self:
        return copy.deepcopy(self)

    def update(self, scans: NDArray[np.uint16]) -> NDArray[np.int16]:
        if scans.ndim != 2 or scans.shape[1] != len(SCAN):
            raise ValueError(f"scans have the shape {scans.shape}: give (n, {len(SCAN)})")
        out = np.empty((len(scans), _COLUMNS), np.int16)
        taken = np.ascontiguousarray(scans, np.uint16)
        _kernels.filter_scans(taken, self._place, self._smoothed, self._readings, self._sums, out)
        return out


def settled_filter(
    scan: NDArray[np.uint16], sheets: tuple[VelostatParameters, VelostatParameters]
) -> DeviceFilter:
    """Return filters in their state after a long rest. ``scan`` is a scan without load."""
    device = DeviceFilter()
    warm_up = np.tile(scan, (ROUND, 1))
    warm_up[:, 2:4] = [open_reading(v) for v in sheets]
    device.update(warm_up)
    return device


ElectricalNoise = tuple[NDArray[np.float64], NDArray[np.float64]]


class Fingertips(ABC):
    """Base class of the simulated electronics of both fingertips: from motion to raw samples.

    No force acts on the fingertips at the start.
    """

    def __init__(self, draw: PinchDraw) -> None:
        self._draw = draw
        self.sample = 0
        self._sheet_state = np.zeros((2, 2, TAXELS))

    def fork(self) -> Self:
        other = copy.copy(self)
        other._sheet_state = self._sheet_state.copy()
        return other

    @abstractmethod
    def _electrical_noise(self, samples: int) -> list[ElectricalNoise]:
        """Return the noise of each fingertip in the next ``samples`` samples, V.

        Each pair holds the noise of the piezo and of the force sheet.
        """

    def read(self, motion: NDArray[np.float64]) -> NDArray[np.uint16]:
        scans = np.empty((len(motion), len(SCAN)), np.uint16)
        for f, (piezo, force) in enumerate(self._electrical_noise(len(motion))):
            scans[:, f] = piezo_readings(motion[:, f, BUFFER] + piezo)
            # The array lies between pad and board, so the contact force loads it, not the mount's.
            scans[:, 2 + f] = force_readings(
                motion[:, f, CONTACT_FORCE], self._draw.shares[f], self._draw.velostat[f], force,
                1 / FINGERTIP_RATE, self._sheet_state[f], self.sample,
            )  # fmt: skip
            scans[:, 4 + f] = motion[:, f, INDENTATION] > 0
        self.sample += len(motion)
        return scans


class PinchFingertips(Fingertips):
    """Simulated converters of both fingertips for one pinch. Their noise is drawn in advance."""

    def __init__(self, draw: PinchDraw, times: NDArray[np.float64]) -> None:
        super().__init__(draw)
        self._noise = []
        for f in range(2):
            phase = draw.rng.uniform(0, 2 * math.pi)
            angle = 2 * math.pi * draw.noise[f].mains_rate * times + phase
            self._noise.append(
                electrical_noise(draw.noise[f], draw.velostat[f].noise, angle, draw.rng)
            )
        if draw.recorded is not None:
            piezos = draw.recorded.draw(len(times), draw.rng)
            self._noise = [(p, force) for p, (_, force) in zip(piezos, self._noise, strict=True)]

    def _electrical_noise(self, samples: int) -> list[ElectricalNoise]:
        rows = slice(self.sample, self.sample + samples)
        return [(piezo[rows], force[rows]) for piezo, force in self._noise]


class ScanStream(ABC):
    """Base class of endless streams of scans. :meth:`read` returns any number of them."""

    def __init__(self) -> None:
        self._left = np.empty((0, len(SCAN)), np.uint16)

    @abstractmethod
    def _next_scans(self) -> NDArray[np.uint16]:
        pass

    def read(self, samples: int) -> NDArray[np.uint16]:
        """Return the next scans, which are readings of all channels in a fixed order.

        Returns
        -------
        ndarray
            Shape (samples, 6), in the order of :data:`firstcontact.twin.sensor.SCAN`.
        """
        parts, count = [self._left], len(self._left)
        while count < samples:
            parts.append(self._next_scans())
            count += len(parts[-1])
        joined = np.concatenate(parts)
        self._left = joined[samples:]
        return joined[:samples]


class StreamFingertips(Fingertips):
    def __init__(self, draw: PinchDraw, rng: np.random.Generator) -> None:
        super().__init__(draw)
        self._rng = rng
        self._phases = rng.uniform(0, 2 * math.pi, 2)

    def use_draw(self, draw: PinchDraw) -> None:
        """Use the sensor parameters of ``draw`` from now on: another pinch of this session."""
        for f, (old, new) in enumerate(zip(self._draw.velostat, draw.velostat, strict=True)):
            self._sheet_state[f] *= (old.conductance / new.conductance) ** (1 / new.exponent)
        self._draw = draw

    def _electrical_noise(self, samples: int) -> list[ElectricalNoise]:
        count = np.arange(self.sample, self.sample + samples)
        sheets = self._draw.velostat
        # Fraction of a turn since the start, exact even after days.
        turns = count * self._draw.noise[0].mains_rate % FINGERTIP_RATE
        angle = 2 * math.pi * turns / FINGERTIP_RATE
        return [
            electrical_noise(noise, sheet.noise, angle + phase, self._rng)
            for noise, sheet, phase in zip(self._draw.noise, sheets, self._phases, strict=True)
        ]


def strip_contacts(
    scans: NDArray[np.uint16], first_sample: int = 0, earlier: Sequence[Contact] = ()
) -> list[Contact]:
    """Return the new contacts that the strips show in ``scans``, in order of time.

    ``first_sample`` is the number of the first scan. Fingers in ``earlier`` contacts are left out.
    """
    return mask_contacts(scans[:, 4:6] != 0, first_sample, earlier)


def mask_contacts(
    closed: NDArray[np.bool_], first_sample: int, earlier: Sequence[Contact]
) -> list[Contact]:
    """Return the new contacts in order of time, given a mask of closed strips, shape (n, 2).

    ``first_sample`` is the number of the first row. Fingers in ``earlier`` contacts are left out.
    """
    contacts = []
    for f in () if len(earlier) == 2 else Finger:
        sample = first_closed_sample(closed[:, f], first_sample)
        if sample is not None and all(c.finger != f for c in earlier):
            contacts.append(Contact(f, sample, sample))
    return sorted(contacts, key=lambda c: c.sample)
