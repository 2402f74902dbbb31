"""Largest rise of a taxel's voltage above its unloaded level, over both fingers."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Layout, Physical

#: Time at the start of a closing whose mean is the unloaded level, s.
REST = 0.05


class Taxels:
    """Tracker of the largest rise of a taxel's voltage above its unloaded level.

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
        """Measure the unloaded levels again, at the start of a closing with an empty hand."""
        self._sum[:] = 0.0
        self._count = 0

    def update(self, data: NDArray[Any]) -> float:
        """Process raw samples, shape (samples, channels).

        Returns
        -------
        float
            Largest rise of a taxel of either finger above its unloaded level, at the last sample,
            V. It is 0 until the unloaded levels are known.
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
