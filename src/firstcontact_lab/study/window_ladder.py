"""Any-time estimator that consists of one window model for each window length.

Each model has a conformal interval from held-out sessions. With it, the study compares registered
estimators and users' regressors with the network.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, ModelError
from firstcontact.models import Predictions, Task, Touches, Windows, make_estimator
from firstcontact.models.interval import SHORE_A, Interval, conformal_interval, least_predictions
from firstcontact.models.splits import inner_folds
from firstcontact.models.values import Values
from firstcontact.models.windows.window_model import usable
from firstcontact.signal import samples_in

#: Number of folds for calibrating intervals, and coverage of the intervals.
CALIBRATION_FOLDS, LEVEL = 5, 0.9
#: Smallest number of windows of a length for training.
LEAST = 10

Groups = NDArray[np.str_] | None
Predict = Callable[[Windows], Values]


@dataclass(frozen=True, slots=True, eq=False)
class _Rung:
    """Model of one window length. It has no interval if there were too few held-out windows."""

    samples: int
    predict: Predict
    mean: float
    sd: float
    interval: Interval | None


class LadderModel:
    """Any-time model that consists of window models of several lengths.

    For each contact, it uses the longest window that ends before the second contact.
    """

    def __init__(self, rungs: Sequence[_Rung]) -> None:
        self._rungs = tuple(rungs)

    @property
    def lengths(self) -> tuple[int, ...]:
        return tuple(rung.samples for rung in self._rungs)

    def predict_touches(self, touches: Touches) -> Predictions:
        n, shortest = len(touches), self._rungs[0]
        # Of constant signals and too early second contacts: the mean in training, out of range.
        out = Predictions(
            value=np.full(n, shortest.mean),
            spread=np.full(n, shortest.sd),
            low=np.full(n, SHORE_A[0]),
            high=np.full(n, SHORE_A[1]),
            out_of_range=np.ones(n, np.bool_),
            elapsed=touches.valid / touches.rate,
        )
        place = np.searchsorted(self.lengths, touches.valid, side="right") - 1
        for number, rung in enumerate(self._rungs):
            rows = np.flatnonzero(place == number)
            X = _windows(touches.take(rows), rung.samples)
            rows, X = rows[usable(X)], X[usable(X)]
            if not len(rows):
                continue
            out.value[rows] = np.clip(_checked(rung.predict(X), len(X)), *SHORE_A)
            out.spread[rows] = rung.sd
            out.out_of_range[rows] = False
            out.elapsed[rows] = rung.samples / touches.rate
            if rung.interval is not None:
                out.low[rows], out.high[rows] = rung.interval.around_all(out.value[rows])
        return out


def fit_window_ladder(
    estimator: object,
    touches: Touches,
    shore_a: Values,
    groups: Groups = None,
    *,
    seed: int = 0,
) -> LadderModel:
    """Fit an estimator, or a user's regressor, to windows of each length. Return the model."""

    def fit(X: Windows, y: Values, groups: Groups) -> Predict:
        made = make_estimator(estimator, Task.REGRESSION, touches.rate)
        return made.fit(X, y, groups, seed=seed).predict

    rungs = []
    for ms in Touches.SCORED_MS:
        samples = samples_in(ms / 1000, touches.rate)
        positions = np.flatnonzero(touches.valid >= samples)
        X = _windows(touches.take(positions), samples)
        good = usable(X)
        X, positions = X[good], positions[good]
        if len(positions) >= LEAST:
            sessions = None if groups is None else groups[positions]
            rungs.append(_fit_rung(fit, X, shore_a[positions], sessions, samples, seed))
    if not rungs:
        raise ArgumentError(
            f"{len(touches)} contacts are too few to learn from: record {LEAST} or more pinches"
        )
    return LadderModel(rungs)


def _fit_rung(
    fit: Callable[[Windows, Values, Groups], Predict],
    X: Windows,
    y: Values,
    groups: Groups,
    samples: int,
    seed: int,
) -> _Rung:
    predicted = np.full(len(y), np.nan)
    for train, ask in inner_folds(y, groups, seed, CALIBRATION_FOLDS):
        predict = fit(X[train], y[train], None if groups is None else groups[train])
        predicted[ask] = _checked(predict(X[ask]), len(ask))
    is_held_out = np.isfinite(predicted)
    answers, truth = np.clip(predicted[is_held_out], *SHORE_A), y[is_held_out]
    enough = len(truth) >= least_predictions(LEVEL)
    interval = conformal_interval(answers, truth, LEVEL) if enough else None
    sd = float(np.sqrt(np.mean((answers - truth) ** 2))) if len(truth) else float(y.std())
    return _Rung(samples, fit(X, y, groups), float(y.mean()), max(sd, 1e-3), interval)


def _windows(touches: Touches, samples: int) -> Windows:
    """Return the first ``samples`` samples after each contact, shape (n, samples, 1), V."""
    return touches.signals[:, touches.lead : touches.lead + samples, None].copy()


def _checked(answers: Values, n: int) -> Values:
    values = np.asarray(answers, dtype=np.float64)
    if values.shape != (n,) or not np.isfinite(values).all():
        finite = "" if np.isfinite(values).all() else ", with values that are no numbers"
        raise ModelError(
            f"the regressor predicted {n} windows with an array of shape {values.shape}{finite}: "
            "it must give one finite Shore A value per window"
        )
    return values
