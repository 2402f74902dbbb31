"""Tracking of the highest taxel of both fingers above its unloaded level."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Layout, Physical

#: Time at the start of a closing whose mean is the unloaded level, s.
REST = 0.05


class Taxels:
    """Tracker of the highest taxel of both fingers, updated with each block.

    Parameters
    ----------
    layout
        Columns of the samples. Without force channels the result is always 0.
    """

    def __init__(self, layout: Layout) -> None:
        columns = layout.columns(ChannelKind.FORCE)
        self._physical = Physical(layout, columns)
        self._rest_samples = round(REST * layout.rate)
        self._sum = np.zeros(len(columns))
        self._count = 0

    def begin(self) -> None:
        """Restart the unloaded level at the beginning of a closing, while the hand is empty."""
        self._sum[:] = 0.0
        self._count = 0

    def update(self, data: NDArray[Any]) -> float:
        """Process raw samples, shape (samples, channels).

        Returns
        -------
        float
            Voltage of the highest taxel above its unloaded level at the last sample, V. 0 until
            the unloaded level is known.
        """
        if not self._sum.size or not len(data):
            return 0.0
        if self._count < self._rest_samples:
            volts = self._physical(data[: self._rest_samples - self._count])
            self._sum += volts.sum(axis=0)
            self._count += len(volts)
            if self._count < self._rest_samples:
                return 0.0
        return float((self._physical(data[-1:])[0] - self._sum / self._count).max())
