"""Floors to stand on: the mean of the training targets, and the peak amplitude alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.stiffness.estimator import Arrays, Spec, Task, Values, Windows, training_spec


@dataclass(frozen=True, eq=False)
class ConstantModel:
    """Always the same answer."""

    spec: Spec
    value: float
    kind: ClassVar[str] = "constant"

    @property
    def notes(self) -> Mapping[str, Any]:
        """The answer."""
        return {"value": self.value}

    def predict(self, X: Windows) -> Values:
        """The same answer for every window, shape (n,)."""
        self.spec.check(X)
        return np.full(len(X), self.value)

    def predict_one(self, window: Windows) -> float:
        """The same answer again."""
        self.spec.check_one(window)
        return self.value

    def to_arrays(self) -> Arrays:
        """The answer."""
        return {"value": np.array([self.value])}

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: Arrays) -> Self:
        """The inverse of :meth:`to_arrays`."""
        return cls(spec, float(arrays["value"][0]))


@dataclass(frozen=True)
class TrainMean:
    """The mean of the training targets, or the most frequent class."""

    task: Task
    rate: float
    name: str = "train_mean"

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> ConstantModel:
        """See :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        if self.task is Task.REGRESSION:
            return ConstantModel(spec, float(y.mean()))
        values, counts = np.unique(y, return_counts=True)
        return ConstantModel(spec, float(values[counts.argmax()]))


def _log_peak(X: NDArray[Any]) -> Values:
    """Logarithm of the largest magnitude of each window (n, samples, channels)."""
    peak: Values = np.log(np.abs(X).max(axis=(1, 2)).astype(np.float64))
    return peak


@dataclass(frozen=True, eq=False)
class PeakModel:
    """A parabola in the log peak, or the class with the nearest mean log peak.

    ``weights`` holds the parabola (highest power first) and the range of the
    training targets, beyond which a parabola means nothing; for
    classification the mean log peak of each class.
    """

    spec: Spec
    weights: Values
    kind: ClassVar[str] = "peak"

    def __post_init__(self) -> None:
        expected = len(self.spec.classes) or 5
        if self.weights.shape != (expected,):
            raise InputError(f"a peak model needs {expected} weights, not {self.weights.shape}")

    @property
    def notes(self) -> Mapping[str, Any]:
        """Nothing was chosen."""
        return {}

    def predict(self, X: Windows) -> Values:
        """Answers, shape (n,)."""
        self.spec.check(X)
        peak = _log_peak(X)
        if self.spec.task is Task.REGRESSION:
            low, high = self.weights[3:]
            fitted: Values = np.clip(np.polyval(self.weights[:3], peak), low, high)
            return fitted
        nearest = np.abs(peak[:, None] - self.weights).argmin(axis=1)
        chosen: Values = np.array(self.spec.classes)[nearest]
        return chosen

    def predict_one(self, window: Windows) -> float:
        """One answer."""
        return float(self.predict(window[None])[0])

    def to_arrays(self) -> Arrays:
        """The weights."""
        return {"weights": self.weights}

    @classmethod
    def from_arrays(cls, spec: Spec, arrays: Arrays) -> Self:
        """The inverse of :meth:`to_arrays`."""
        return cls(spec, arrays["weights"])


@dataclass(frozen=True)
class Peak:
    """What the peak amplitude alone can tell."""

    task: Task
    rate: float
    name: str = "peak"

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> PeakModel:
        """See :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        peak = _log_peak(X)
        if self.task is Task.CLASSIFICATION:
            return PeakModel(spec, np.array([peak[y == c].mean() for c in spec.classes]))
        powers = np.vander(peak - peak.mean(), 3)
        a, b, c = np.linalg.lstsq(powers, y, rcond=None)[0]
        m = peak.mean()  # back from the centred parabola, which is better conditioned
        weights = [a, b - 2 * a * m, c - b * m + a * m * m, y.min(), y.max()]
        return PeakModel(spec, np.array(weights))
