"""The published threshold: three sigmas of the steady state."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._stream import WindowDetector
from firstcontact.core import ORANGE, InputError, Judgement, Layout

#: Height where contacts come out of rest, not out of a motor's noise.
ABOVE_REST = 10.0
#: No height above this can be meant.
HIGHEST = 1e6


class ThresholdDetector(WindowDetector):
    """Fires when a new sample is more than ``sigmas`` away from the steady mean.

    The old part of a window was judged when it was new, so only the newest
    3 ms are looked at: the same first trigger as with the whole window, and no
    crossing is counted twice.

    Parameters
    ----------
    sigmas
        Height of the threshold.

    Examples
    --------
    >>> from firstcontact.contact import detect
    >>> from firstcontact.testing._closings import closing
    >>> pinch = closing(5)
    >>> {contact.finger.name for contact in detect(ThresholdDetector(8.0), pinch)} != set()
    True
    """

    name: ClassVar[str] = "three_sigma"
    title: ClassVar[str] = "3σ threshold"
    colour: ClassVar[str] = ORANGE

    def __init__(self, sigmas: float = 3.0) -> None:
        self.sigmas = sigmas

    @classmethod
    def untrained(cls, layout: Layout) -> Self:
        """As published above a motor; high above rest, of which there is far more than of motor."""
        return cls(ABOVE_REST) if None in layout.vibration_fingers else cls()

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """The height."""
        return {"sigmas": np.array(self.sigmas)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of :meth:`to_arrays`."""
        sigmas = np.asarray(arrays.get("sigmas", np.nan))
        if sigmas.shape != () or not 0.0 < sigmas <= HIGHEST:
            raise InputError("the detector's array 'sigmas' is missing or out of range: train it")
        return cls(float(sigmas))

    def fires(self, windows: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Say which windows hold a crossing in their newest part."""
        new = windows[:, :, -self._sizes.step :]
        return np.asarray(np.abs(new).max(axis=2) > self.sigmas)

    def judgement(self, rate: float) -> Judgement:
        """The height alone."""
        return Judgement("crossing", {"sigmas": self.sigmas}, {}, 1)
