"""Filters of the microcontroller, which turn raw scans into samples.

They use integer arithmetic, so that the firmware gives the same bits. The loops are compiled:
``core/c/fingertips.c``.
"""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import TAXELS, fingertip_layout, kernels
from firstcontact.twin._sensor import SCAN, VelostatParameters, open_reading

#: Number of readings of a taxel in the sliding mean.
FORCE_READINGS = 8
#: Number of scans after which every sliding mean holds new readings only.
ROUND = TAXELS * FORCE_READINGS
_COLUMNS = fingertip_layout().width
_kernels = kernels()


def smoothed(counts: NDArray[np.uint16]) -> NDArray[np.int16]:
    """Return one piezo's converter counts, smoothed as the device smooths them."""
    out = np.empty(counts.size, np.int16)
    _kernels.smooth(np.ascontiguousarray(counts), out)
    return out


class DeviceFilter:
    """Filters of the microcontroller, from its power-on, for blocks of any size.

    Piezo: exponential smoothing y = (y + x) >> 1 in 1/32 counts, with alpha = 0.5, rounded down.
    The first reading is the initial state.

    Force: sliding mean over the last 8 readings of each taxel, exact in 1/32 counts. The first
    reading of a taxel counts as 8 equal readings. A taxel without a reading is 0. Scan i reads
    taxel i modulo 6.

    A strip is 1 if its reading is not 0. Counts above 1023 are treated as 1023.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Clear the state, as a restart of the device does."""
        # Position of the next scan in a cycle of ROUND scans, -1 before the first scan.
        self._place = np.full(1, -1, np.int64)
        self._smoothed = np.zeros(2, np.int64)
        self._readings = np.full((2, TAXELS, FORCE_READINGS), -1, np.int64)
        self._sums = np.zeros((2, TAXELS), np.int64)

    def fork(self) -> Self:
        """Return an independent copy in the same state."""
        return copy.deepcopy(self)

    def update(self, scans: NDArray[np.uint16]) -> NDArray[np.int16]:
        """Filter the next scans.

        Parameters
        ----------
        scans
            Raw readings in the order of :data:`firstcontact.twin._sensor.SCAN`, shape (n, 6).

        Returns
        -------
        ndarray
            Samples as the device sends them, in 1/32 counts, in the order of
            :func:`firstcontact.core._layout.fingertip_layout`, shape (n, 16). The sizes of the
            blocks do not change the numbers.

        Raises
        ------
        ValueError
            The scans have another shape.
        """
        if scans.ndim != 2 or scans.shape[1] != len(SCAN):
            raise ValueError(f"scans have shape {scans.shape}, not (n, {len(SCAN)})")
        out = np.empty((len(scans), _COLUMNS), np.int16)
        taken = np.ascontiguousarray(scans, np.uint16)
        _kernels.filter_scans(taken, self._place, self._smoothed, self._readings, self._sums, out)
        return out


def settled_filter(
    scan: NDArray[np.uint16], sheets: tuple[VelostatParameters, VelostatParameters]
) -> DeviceFilter:
    """Return a filter in the state after a long rest, with unloaded fingers."""
    device = DeviceFilter()
    warm_up = np.tile(scan, (ROUND, 1))
    warm_up[:, 2:4] = [open_reading(v) for v in sheets]
    device.update(warm_up)
    return device
