"""From the motion of a pinch to what the device sends of it."""

from __future__ import annotations

import copy
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.twin._filter import DeviceFilter, settled_filter
from firstcontact.twin._fingertips import PinchFingertips


class PinchReadings:
    """The converters through one pinch and the microcontroller behind them.

    Parameters
    ----------
    tips
        New.
    """

    def __init__(self, tips: PinchFingertips) -> None:
        self._tips = tips
        self._device: DeviceFilter | None = None

    @property
    def sample(self) -> int:
        """Number of the next sample."""
        return self._tips.sample

    def read(self, motion: NDArray[np.float64]) -> NDArray[np.int16]:
        """The next samples, shape (n, 16), of a motion of shape (n, 2, 5)."""
        scans = self._tips.read(motion)
        if self._device is None:
            self._device = settled_filter(scans[0], self._tips.sheets)
        return self._device.update(scans)

    def fork(self) -> Self:
        """Readings that go on from here by themselves, with the same noise."""
        other = copy.copy(self)
        other._tips = self._tips.fork()
        other._device = None if self._device is None else self._device.fork()
        return other
