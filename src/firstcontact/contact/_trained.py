"""What detectors share that have to learn before they can detect."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._registry import untrained_name
from firstcontact.contact._stream import WindowDetector, WindowSizes
from firstcontact.contact._training import usable
from firstcontact.core import Dataset, InputError, Layout

#: Bound of stored weights. Scores of any window stay finite below it; trained weights are around 1.
LARGEST = 1e100


class TrainedDetector(WindowDetector):
    """A detector of windows that learns.

    Parameters
    ----------
    seed
        Of what is drawn for training.
    """

    learns: ClassVar[bool] = True
    #: Lowest rate, Hz: below it some part of a window has no samples.
    lowest: ClassVar[float]

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._rate = 0.0

    @property
    @abstractmethod
    def trained(self) -> bool:
        """Whether it has learned, or was loaded."""

    @property
    def rate(self) -> float | None:
        """The sampling rate that it was trained at, Hz; None before."""
        return self._rate or None

    @property
    def noun(self) -> str:
        """Its title within a sentence."""
        return self.title if self.title.isupper() else self.title.lower()

    def start(self, layout: Layout) -> None:
        """Begin a new closing: forget the stream and release all fingers.

        Raises
        ------
        InputError
            When it was not trained, or for another rate.
        """
        self._require_training("fit it or load a trained one")
        if layout.rate != self._rate:
            raise InputError(
                f"the {self.title} detector was trained at {self._rate:g} Hz and the layout says "
                f"{layout.rate:g} Hz: make one with `firstcontact train --rate {layout.rate:g}`"
            )
        super().start(layout)

    def _require_training(self, otherwise: str) -> None:
        if not self.trained:
            raise InputError(f"the {self.noun} detector has not been trained: {otherwise}")

    def _sizes_of(self, dataset: Dataset) -> tuple[float, WindowSizes]:
        """Rate of what it is to learn from, Hz, and the lengths there."""
        rate = dataset.layout.rate if len(dataset) else self.lowest
        if rate < self.lowest:
            raise InputError(
                f"the {self.noun} detector needs samples at {self.lowest:g} Hz or more and these "
                f"come at {rate:g} Hz: use --detector {untrained_name()}"
            )
        return rate, self.sizes(rate)

    def _too_few(self, shown: int) -> InputError:
        return InputError(
            f"{shown} pinches have a first contact in their labels, a living sensor and "
            f"at least 43 ms of quiet before it: the {self.noun} detector needs two or more"
        )


def spread_out(dataset: Dataset, sizes: WindowSizes, early: float, most: int) -> Dataset:
    """Up to so many pinches that can be learned from.

    Evenly spaced, not drawn: every session and object keeps its share.
    """
    able = np.flatnonzero([usable(p, sizes, early) for p in dataset.pinches])
    spaced = np.linspace(0, max(0, len(able) - 1), min(most, len(able)))
    return dataset.take(able[spaced.round().astype(np.intp)])


def kept(
    arrays: Mapping[str, NDArray[Any]], name: str, shape: tuple[int, ...]
) -> NDArray[np.float64]:
    """An array that a detector has written of itself.

    Raises
    ------
    InputError
        It is missing, has another shape, is not finite, or is so large that scores overflow.
    """
    value = np.array(arrays.get(name, np.nan), dtype=np.float64)
    if value.shape != shape or not (np.abs(value) < LARGEST).all():
        raise InputError(f"the detector's array {name!r} is missing or damaged: train it again")
    return value
