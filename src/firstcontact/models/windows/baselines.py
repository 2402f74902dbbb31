"""Baseline estimators: the mean of the training targets, and the peak amplitude alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ModelError
from firstcontact.core.display import GREEN, GREY
from firstcontact.models.estimator import Estimator, training_spec
from firstcontact.models.values import Task, Values, Windows
from firstcontact.models.windows.window_model import ArrayCheck, ModelFromArrays, Spec, WindowModel


class ConstantModel(ModelFromArrays):
    """Model with the same prediction for every window."""

    kind: ClassVar[str] = "constant"
    declared: ClassVar[Mapping[str, ArrayCheck]] = {"value": ArrayCheck((1,))}

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        self.value = float(self._arrays["value"][0])
        if spec.classes and self.value not in spec.classes:
            raise ModelError(
                f"the model's constant prediction {self.value:g} is not one of its classes: train "
                "the model again"
            )

    @property
    def notes(self) -> Mapping[str, Any]:
        return {"value": self.value}

    def outputs(self, X: Windows) -> Values:
        return np.full((len(X), 1), self.value)

    def choose(self, outputs: NDArray[Any]) -> NDArray[np.intp]:
        """Return the index of the constant class for each window, shape (n,)."""
        return np.searchsorted(self.spec.classes, outputs[:, 0])


@dataclass(frozen=True)
class TrainMean(Estimator):
    """Estimator that predicts the mean of the training targets, or the most frequent class."""

    name: ClassVar[str] = "train_mean"
    title: ClassVar[str] = "Train mean"
    colour: ClassVar[str] = GREY
    model: ClassVar[type[WindowModel]] = ConstantModel
    baseline: ClassVar[bool] = True

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> ConstantModel:
        spec = training_spec(self.task, self.rate, X, y, groups)
        if self.task is Task.REGRESSION:
            return ConstantModel(spec, np.array([y.mean()]))
        values, counts = np.unique(y, return_counts=True)
        return ConstantModel(spec, values[[counts.argmax()]])


def _log_peak(X: NDArray[Any]) -> Values:
    """Return ln(largest magnitude) of each window, shape (windows,).

    ``X`` has the shape (windows, samples, channels).
    """
    peak: Values = np.log(np.abs(X).max(axis=(1, 2)).astype(np.float64))
    return peak


class PeakModel(ModelFromArrays):
    """Model that predicts from the logarithm of a window's peak amplitude alone."""

    kind: ClassVar[str] = "peak"
    declared: ClassVar[Mapping[str, ArrayCheck]] = {"weights": ArrayCheck(("weights",))}

    def __init__(self, spec: Spec, *arrays: NDArray[Any]) -> None:
        super().__init__(spec, *arrays)
        self.weights = self._arrays["weights"]

    @classmethod
    def sizes(cls, spec: Spec) -> dict[str, int]:
        return {"weights": len(spec.classes) or 5}

    @property
    def notes(self) -> Mapping[str, Any]:
        """Empty mapping: the training chooses no hyper-parameters."""
        return {}

    def outputs(self, X: Windows) -> Values:
        """Return predictions (n, 1), or minus the distances to the class means, (n, classes)."""
        peak = _log_peak(X)[:, None]
        if self.spec.task is Task.REGRESSION:
            low, high = self.weights[3:]
            fitted: Values = np.clip(np.polyval(self.weights[:3], peak), low, high)
            return fitted
        near: Values = -np.abs(peak - self.weights)
        return near


@dataclass(frozen=True)
class Peak(Estimator):
    """Estimator that uses only ln(peak amplitude) of a window.

    It fits a parabola for a regression, and predicts the class with the nearest mean otherwise.
    """

    name: ClassVar[str] = "peak"
    title: ClassVar[str] = "Peak amplitude"
    colour: ClassVar[str] = GREEN
    model: ClassVar[type[WindowModel]] = PeakModel
    baseline: ClassVar[bool] = True

    def fit(
        self, X: Windows, y: Values, groups: NDArray[Any] | None = None, seed: int = 0
    ) -> PeakModel:
        """Fit the parabola or the class means; see :meth:`Estimator.fit`."""
        spec = training_spec(self.task, self.rate, X, y, groups)
        peak = _log_peak(X)
        if self.task is Task.CLASSIFICATION:
            return PeakModel(spec, np.array([peak[y == c].mean() for c in spec.classes]))
        powers = np.vander(peak - peak.mean(), 3)
        a, b, c = np.linalg.lstsq(powers, y, rcond=None)[0]
        m = peak.mean()  # undo the centring, which made the fit better conditioned
        weights = [a, b - 2 * a * m, c - b * m + a * m * m, y.min(), y.max()]
        return PeakModel(spec, np.array(weights))
