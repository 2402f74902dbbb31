"""Samples of the device, computed from the motion of a pinch."""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.twin._filter import DeviceFilter, settled_filter
from firstcontact.twin._fingertips import PinchFingertips


class PinchReadings:
    """Converters for one pinch, with the microcontroller behind them.

    Parameters
    ----------
    tips
        New converters.
    """

    def __init__(self, tips: PinchFingertips) -> None:
        self._tips = tips
        self._device: DeviceFilter | None = None

    @property
    def sample(self) -> int:
        """Number of the next sample."""
        return self._tips.sample

    def read(self, motion: NDArray[np.float64]) -> NDArray[np.int16]:
        """Return the next samples, shape (n, 16), of a motion of shape (n, 2, 5)."""
        scans = self._tips.read(motion)
        if self._device is None:
            self._device = settled_filter(scans[0], self._tips.sheets)
        return self._device.update(scans)

    def fork(self) -> Self:
        """Return an independent copy in the same state, with the same noise."""
        other = copy.copy(self)
        other._tips = self._tips.fork()
        other._device = None if self._device is None else self._device.fork()
        return other
