"""Contact detector with a logistic regression on loudness.

It looks every 0.4 ms. Four consecutive looks must agree.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain.image import DetectorConstants, DetectorKind
from firstcontact.contact._logistic_training import (
    EACH,
    FLOOR,
    LOOKS,
    best_threshold,
    cut_looks,
    fit_line,
    parts,
)
from firstcontact.contact.closing_start import cut_closings
from firstcontact.contact.detector import TrainedDetector, spread_out, stored_array
from firstcontact.contact.training import session_groups
from firstcontact.core import Dataset, InputError
from firstcontact.core.display import GREEN

#: Least deviation of a new sample, in sigmas, for which a window is evaluated.
AWAKE = 3.0
#: Largest number of training pinches, and number of folds for the threshold.
PINCHES = 1000
FOLDS = 3


class LogisticDetector(TrainedDetector):
    """Detector that reports a contact if four scores in a row, 0.4 ms apart, exceed a threshold."""

    name: ClassVar[str] = "logistic"
    title: ClassVar[str] = "Logistic"
    colour: ClassVar[str] = GREEN
    step: ClassVar[float] = 0.0004
    lowest: ClassVar[float] = 1020.0
    duration: ClassVar[float] = 0.020 + (LOOKS - 1) * step
    reach: ClassVar[int] = 22

    def __init__(self, seed: int = 0) -> None:
        super().__init__(seed)
        self._line: NDArray[np.float64] | None = None

    @property
    def trained(self) -> bool:
        """True after training or loading."""
        return self._line is not None

    def fit(self, dataset: Dataset, early: float = 0.0) -> Self:
        """Learn from pinches with known first contacts, each from the start of its closing."""
        dataset = cut_closings(dataset)
        rate, sizes = self._window_sizes(dataset)
        subset = spread_out(dataset, sizes, early, PINCHES)
        rng = np.random.default_rng(self.seed)
        looks = [cut_looks(pinch, sizes, early, rng) for pinch in subset.pinches]
        has_contact = np.array([look.shows.any() for look in looks], dtype=np.bool_)
        looks = [look for look in looks if look.shows.any()]
        if len(looks) < 2:
            raise self._too_few(len(looks))
        groups = session_groups(subset.sessions[has_contact], FOLDS) % FOLDS
        levels = np.empty((len(looks), 2))
        for fold in np.unique(groups):
            line = fit_line(
                [look for look, g in zip(looks, groups, strict=True) if g != fold], self.seed
            )
            for place in np.flatnonzero(groups == fold):
                levels[place] = looks[place].levels(line)
        has_levels = np.isfinite(levels).all(axis=1)
        if has_levels.sum() < 2:
            raise self._too_few(has_levels.sum())
        self._line = fit_line(looks, self.seed)
        self._line[-1] -= best_threshold(levels[has_levels])
        self._rate = rate
        return self

    def constants(self, rate: float) -> DetectorConstants:
        """Return the constants of this detector for the chain."""
        self._check_rate(rate)
        return self._constants(
            rate,
            DetectorKind.LOGISTIC,
            looks=LOOKS,
            lengths=parts(rate),
            threshold=AWAKE,
            floor=FLOOR,
            line=self._line,
        )

    def to_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Return the rate, the weights, and the intercept less the threshold."""
        self._require_training("there is nothing to save")
        assert self._line is not None
        return {"line": self._line, "rate": np.asarray(self._rate)}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """Restore a detector from :meth:`to_arrays`."""
        detector = cls()
        detector._line = stored_array(arrays, "line", (2 * EACH + 1,))
        detector._rate = float(stored_array(arrays, "rate", ()))
        if detector._rate < cls.lowest:
            raise InputError(
                f"the detector's sampling rate is {detector._rate:g} Hz, but must be "
                f"{cls.lowest:g} Hz or more: train it on recordings with a higher rate"
            )
        return detector
