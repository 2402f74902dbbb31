"""The published threshold: three sigmas of the steady state."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.stream import WindowDetector


class ThresholdDetector(WindowDetector):
    """Fires when a new sample is more than ``sigmas`` away from the steady mean.

    The old part of a window was judged when it was new, so only the newest
    3 ms are looked at: the same first trigger as with the whole window, and no
    crossing is counted twice.

    Parameters
    ----------
    sigmas
        Height of the threshold.
    """

    name: ClassVar[str] = "three_sigma"

    def __init__(self, sigmas: float = 3.0) -> None:
        self.sigmas = sigmas

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Say which windows hold a crossing in their newest part."""
        new = windows[:, :, -self._sizes.step :]
        return np.asarray(np.abs(new).max(axis=2) > self.sigmas)
