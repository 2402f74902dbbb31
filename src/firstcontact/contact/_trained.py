"""Base class of detectors that must be trained."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import DetectorConstants
from firstcontact.contact._registry import untrained_name
from firstcontact.contact._training import usable
from firstcontact.contact._window_detector import WindowDetector, WindowSizes
from firstcontact.core import Dataset, InputError

#: Largest stored weight. It keeps scores finite; trained weights are around 1.
LARGEST = 1e100


class TrainedDetector(WindowDetector):
    """Window detector that must be trained."""

    learns: ClassVar[bool] = True
    #: Lowest rate, Hz. Below it some part of a window has no samples.
    lowest: ClassVar[float]

    def __init__(self, seed: int = 0) -> None:
        self.seed = seed
        self._rate = 0.0

    @property
    @abstractmethod
    def trained(self) -> bool:
        """True after training or loading."""

    @property
    def rate(self) -> float | None:
        """Sampling rate of the training data, Hz; None before training."""
        return self._rate or None

    @property
    def noun(self) -> str:
        """Title of the detector, as used within a sentence."""
        return self.title if self.title.isupper() else self.title.lower()

    def constants(self, rate: float) -> DetectorConstants:
        """Return the constants of this detector for the chain."""
        self._check_rate(rate)
        return super().constants(rate)

    def _check_rate(self, rate: float) -> None:
        self._require_training("fit it or load a trained one")
        if rate != self._rate:
            raise InputError(
                f"the {self.title} detector was trained at {self._rate:g} Hz but the samples come "
                f"at {rate:g} Hz: train one for this rate with `firstcontact train --rate {rate:g}`"
            )

    def _require_training(self, otherwise: str) -> None:
        if not self.trained:
            raise InputError(f"the {self.noun} detector has not been trained: {otherwise}")

    def _window_sizes(self, dataset: Dataset) -> tuple[float, WindowSizes]:
        """Return the rate of the training data, Hz, and the window lengths at that rate."""
        rate = dataset.layout.rate if len(dataset) else self.lowest
        if rate < self.lowest:
            raise InputError(
                f"the {self.noun} detector needs samples at {self.lowest:g} Hz or more, not "
                f"{rate:g} Hz: use --detector-type {untrained_name()}"
            )
        return rate, self.sizes(rate)

    def _too_few(self, count: int) -> InputError:
        return InputError(
            f"{count} pinches have a labelled first contact, a working sensor and at least 43 ms "
            f"of quiet before it: the {self.noun} detector needs two or more"
        )


def spread_out(dataset: Dataset, sizes: WindowSizes, early: float, most: int) -> Dataset:
    """Return a dataset of up to ``most`` usable pinches of ``dataset``."""
    usable_positions = np.flatnonzero([usable(p, sizes, early) for p in dataset.pinches])
    spaced = np.linspace(0, max(0, len(usable_positions) - 1), min(most, len(usable_positions)))
    return dataset.take(usable_positions[spaced.round().astype(np.intp)])


def stored_array(
    arrays: Mapping[str, NDArray[Any]], name: str, shape: tuple[int, ...]
) -> NDArray[np.float64]:
    """Return an array that a detector has saved."""
    value = np.array(arrays.get(name, np.nan), dtype=np.float64)
    if value.shape != shape or not (np.abs(value) < LARGEST).all():
        raise InputError(f"the detector's array {name!r} is missing or damaged: train it again")
    return value
