"""What the microcontroller makes of raw scans.

Integer arithmetic throughout, so that firmware gives the same bits.
"""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ADC_COUNTS, SUBCOUNTS, TAXELS, fingertip_layout
from firstcontact.twin._compiled import compiled
from firstcontact.twin._sensor import SCAN, VelostatParameters, open_reading

#: Readings of a taxel that the sliding mean covers.
FORCE_READINGS = 8
#: Scans after which every reading under the sliding means is a new one.
ROUND = TAXELS * FORCE_READINGS
_COLUMNS = fingertip_layout().width


@compiled()
def _clipped(count: int) -> int:
    """What a converter of 10 bits can have read."""
    return min(int(count), ADC_COUNTS - 1)


@compiled()
def _filter(
    scans: NDArray[np.uint16],
    place: NDArray[np.int64],
    smoothed: NDArray[np.int64],
    readings: NDArray[np.int64],
    sums: NDArray[np.int64],
    out: NDArray[np.int16],
) -> None:
    """Take scans in; ``place`` counts the scans of a round, -1 before the first."""
    for i in range(len(scans)):
        if place[0] < 0:
            for f in range(2):
                smoothed[f] = _clipped(scans[i, f]) * SUBCOUNTS
            place[0] = 0
        taxel = place[0] % TAXELS
        slot = place[0] // TAXELS
        for f in range(2):
            smoothed[f] = (smoothed[f] + _clipped(scans[i, f]) * SUBCOUNTS) >> 1
            count = _clipped(scans[i, 2 + f])
            if readings[f, taxel, 0] < 0:
                readings[f, taxel, :] = count
                sums[f, taxel] = FORCE_READINGS * count
            sums[f, taxel] += count - readings[f, taxel, slot]
            readings[f, taxel, slot] = count
            out[i, f] = smoothed[f]
            for k in range(TAXELS):
                out[i, 2 + TAXELS * f + k] = sums[f, k] * (SUBCOUNTS // FORCE_READINGS)
            out[i, 2 + 2 * TAXELS + f] = 1 if scans[i, 4 + f] else 0
        place[0] = (place[0] + 1) % (TAXELS * FORCE_READINGS)


@compiled()
def smoothed(counts: NDArray[np.uint16]) -> NDArray[np.int16]:
    """One piezo's converter counts as the device sends them, in 1/32 counts, shape (samples,).

    For what wants a piezo alone; :class:`DeviceFilter` gives the same numbers.
    """
    out = np.empty(counts.size, np.int16)
    state = _clipped(counts[0]) * SUBCOUNTS
    for i in range(counts.size):
        state = (state + _clipped(counts[i]) * SUBCOUNTS) >> 1
        out[i] = state
    return out


class DeviceFilter:
    """The microcontroller's filters, from its start on, block by block.

    Piezo: y = (y + x) >> 1 in 1/32 counts, exponential smoothing with alpha =
    0.5, rounded down; the first reading is its own history. Force: a sliding mean
    over the last 8 readings of each taxel, exact in 1/32 counts; a taxel's first
    reading stands for the seven before it, and a taxel not read yet is 0. Scan i
    reads taxel i modulo 6. A strip is 1 where its reading is not 0. Counts
    above 1023 count as 1023.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget the past, as a restart does."""
        self._place = np.full(1, -1, np.int64)
        self._smoothed = np.zeros(2, np.int64)
        self._readings = np.full((2, TAXELS, FORCE_READINGS), -1, np.int64)
        self._sums = np.zeros((2, TAXELS), np.int64)

    def fork(self) -> Self:
        """Filters that go on from here by themselves."""
        return copy.deepcopy(self)

    def update(self, scans: NDArray[np.uint16]) -> NDArray[np.int16]:
        """Filter the next scans.

        Parameters
        ----------
        scans
            Raw readings in the order of :data:`firstcontact.twin._sensor.SCAN`,
            shape (n, 6).

        Returns
        -------
        ndarray
            Samples as the device sends them, 1/32 counts, in the order of
            :func:`firstcontact.core._layout.fingertip_layout`, shape (n, 16); the
            same numbers whatever the blocks.

        Raises
        ------
        ValueError
            Scans of another shape.
        """
        if scans.ndim != 2 or scans.shape[1] != len(SCAN):
            raise ValueError(f"scans have shape {scans.shape}, not (n, {len(SCAN)})")
        out = np.empty((len(scans), _COLUMNS), np.int16)
        taken = np.ascontiguousarray(scans, np.uint16)
        _filter(taken, self._place, self._smoothed, self._readings, self._sums, out)
        return out


def settled_filter(
    scan: NDArray[np.uint16], sheets: tuple[VelostatParameters, VelostatParameters]
) -> DeviceFilter:
    """A device that has been reading the unloaded sheets before its first scan, shape (6,)."""
    device = DeviceFilter()
    before = np.tile(scan, (ROUND, 1))
    before[:, 2:4] = [open_reading(v) for v in sheets]
    device.update(before)
    return device
