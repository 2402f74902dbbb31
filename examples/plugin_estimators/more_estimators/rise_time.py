"""Any-time estimator: a line in the time until the signal's peak, and in its height.

It needs neither windows nor the network. The chain calls ``predict`` in recordings and live.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.models import AnytimeEstimator, AnytimeModel, Hints, Prediction, Touches


class RiseTimeModel(AnytimeModel):
    """Line in the logarithms of the peak and of the time until it."""

    kind: ClassVar[str] = "rise_time"

    #: Sampling rate, and samples after the contact with which it predicts: 5, 10 and 15 ms.
    rate = 4936.0
    lengths = (25, 49, 74)
    #: Samples before the contact whose mean is subtracted.
    before = 50

    def __init__(self, line: NDArray[Any], error: float) -> None:
        self.line, self.error = line, error

    @staticmethod
    def features(waves: NDArray[Any]) -> NDArray[np.float64]:
        """Return the features of signals from the contact on, shape (n, 3)."""
        size = np.abs(waves)
        peak, place = size.max(axis=1), size.argmax(axis=1)
        return np.column_stack([np.log(peak + 1e-6), np.log(place + 1.0), np.ones(len(waves))])

    def predict(
        self, signal: NDArray[np.float64], samples: int, finger: int, hints: Hints
    ) -> Prediction | None:
        """Predict from one contact; see :class:`firstcontact.models.Predictor`."""
        quiet, wave = signal[: len(signal) - samples], signal[len(signal) - samples :]
        if not len(quiet) or not np.isfinite(signal).all():
            return None
        value = float(self.features((wave - quiet.mean())[None])[0] @ self.line)
        half = 1.64 * self.error
        return Prediction(value, value - half, value + half, half, self.error)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Return the line and the error."""
        return {"line": self.line, "error": np.array([self.error])}

    @classmethod
    def from_arrays(cls, arrays: dict[str, NDArray[Any]], level: float | None) -> Self:
        """Restore the model."""
        if arrays["line"].shape != (3,):
            raise InputError("the array 'line' must hold 3 numbers: adapt the model again")
        return cls(arrays["line"], float(arrays["error"][0]))


@dataclass(frozen=True)
class RiseTime(AnytimeEstimator):
    """Estimator of :class:`RiseTimeModel`, by least squares."""

    name: ClassVar[str] = RiseTimeModel.kind
    title: ClassVar[str] = "Rise time"
    model: ClassVar[Any] = RiseTimeModel

    def fit(
        self,
        touches: Touches,
        shore_a: NDArray[np.float64],
        sessions: NDArray[np.str_] | None = None,
        seed: int = 0,
    ) -> tuple[RiseTimeModel, Sequence[str]]:
        """Fit the line to all contacts. Each half is predicted from the other half."""
        inputs = RiseTimeModel.features(touches.waves)
        half = np.arange(len(inputs)) % 2 == 0
        errors = []
        for known in (half, ~half):
            line, *_ = np.linalg.lstsq(inputs[known], shore_a[known], rcond=None)
            errors += (inputs[~known] @ line - shore_a[~known]).tolist()
        error = float(np.sqrt(np.mean(np.square(errors))))
        line, *_ = np.linalg.lstsq(inputs, shore_a, rcond=None)
        return RiseTimeModel(line, error), [f"held-out half: RMSE {error:.1f} Shore A"]
