"""How far the loudest taxel is above its unloaded level."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ChannelKind, Layout, Physical

#: The unloaded level is the mean of so much at the start of a closing, s.
REST = 0.05


class Taxels:
    """Follows the force arrays of both fingers, block by block.

    Parameters
    ----------
    layout
        The columns; one without force channels feels nothing.
    """

    def __init__(self, layout: Layout) -> None:
        columns = layout.columns(ChannelKind.FORCE)
        self._physical = Physical(layout, columns)
        self._wanted = round(REST * layout.rate)
        self._sum = np.zeros(len(columns))
        self._count = 0

    def begin(self) -> None:
        """A closing begins, the hand is empty: learn the unloaded level anew."""
        self._sum[:] = 0.0
        self._count = 0

    def update(self, data: NDArray[Any]) -> float:
        """Take raw samples, shape (samples, channels).

        Returns
        -------
        float
            The last sample's loudest taxel above its unloaded level, V; 0 until that is known.
        """
        if not self._sum.size or not len(data):
            return 0.0
        if self._count < self._wanted:
            volts = self._physical(data[: self._wanted - self._count])
            self._sum += volts.sum(axis=0)
            self._count += len(volts)
            if self._count < self._wanted:
                return 0.0
        return float((self._physical(data[-1:])[0] - self._sum / self._count).max())
