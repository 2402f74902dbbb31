"""Window ladder: several window models, each for another window length after a contact.

Each model has a conformal interval from held-out sessions. A ladder predicts at any time, so
registered estimators and users' regressors can be compared with the network.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError
from firstcontact.models import (
    SHORE_A,
    Interval,
    Predictions,
    Task,
    Touches,
    Values,
    Windows,
    conformal_interval,
    inner_folds,
    least_answers,
    make_estimator,
    usable,
)
from firstcontact.signal import SavitzkyGolay, samples_in

#: Lengths of the windows, s.
LENGTHS = tuple(ms / 1000 for ms in Touches.SCORED_MS)
#: Number of folds for calibrating intervals.
FOLDS = 5
#: Smallest number of windows of a length for training.
LEAST = 10

Ask = Callable[[Windows], Values]
#: Function from windows (n, samples, 1), Shore A, sessions or None, rate in Hz and seed to a
#: prediction function.
Learn = Callable[[Windows, Values, NDArray[np.str_] | None, float, int], Ask]


def registered(estimator: object, options: Mapping[str, Any] | None = None) -> Learn:
    """Return a learner (a function that trains a model) for an estimator."""

    def learn(
        X: Windows, y: Values, groups: NDArray[np.str_] | None, rate: float, seed: int
    ) -> Ask:
        made = make_estimator(estimator, Task.REGRESSION, rate, **(options or {}))
        return made.fit(X, y, groups, seed=seed).predict

    return learn


@dataclass(frozen=True, slots=True, eq=False)
class _OneLength:
    """Model of one window length. Without enough held-out windows it has no interval."""

    samples: int
    ask: Ask
    mean: float
    sd: float
    interval: Interval | None


class WindowLadder:
    """Models of several window lengths. For each contact the longest valid window predicts.

    A window is valid if it ends before the second contact.

    Parameters
    ----------
    models
        Models, the shortest window first.
    rate
        Sampling rate of the windows, Hz.
    conditioned
        True if the published filters are applied to the windows.
    """

    def __init__(self, models: Sequence[_OneLength], rate: float, conditioned: bool) -> None:
        self._models, self.rate, self._conditioned = tuple(models), rate, conditioned

    @property
    def lengths(self) -> tuple[int, ...]:
        """Lengths of the windows in samples, ascending."""
        return tuple(model.samples for model in self._models)

    def predict(self, touches: Touches) -> Predictions:
        """Return a prediction for each contact, from its samples before the second contact.

        If the signal is constant, or the second contact comes before the end of the shortest
        window, the prediction is the mean Shore A in training. Its interval is then the whole
        scale, and it is marked out of range.

        Raises
        ------
        InputError
            Predictions are not one finite number per window.
        """
        n, shortest = len(touches), self._models[0]
        out = Predictions(
            value=np.full(n, shortest.mean),
            spread=np.full(n, shortest.sd),
            low=np.full(n, SHORE_A[0]),
            high=np.full(n, SHORE_A[1]),
            out_of_range=np.ones(n, np.bool_),
            elapsed=touches.valid / touches.rate,
        )
        place = np.searchsorted(self.lengths, touches.valid, side="right") - 1
        for number, model in enumerate(self._models):
            rows = np.flatnonzero(place == number)
            X = windows(touches.take(rows), model.samples, self._conditioned)
            rows, X = rows[usable(X)], X[usable(X)]
            if not len(rows):
                continue
            out.value[rows] = np.clip(_checked(model.ask(X), len(X)), *SHORE_A)
            out.spread[rows] = model.sd
            out.out_of_range[rows] = False
            out.elapsed[rows] = model.samples / touches.rate
            if model.interval is not None:
                out.low[rows], out.high[rows] = model.interval.around_all(out.value[rows])
        return out


def fit_window_ladder(
    learn: Learn,
    touches: Touches,
    shore_a: Values,
    groups: NDArray[np.str_] | None = None,
    *,
    seed: int = 0,
    level: float = 0.9,
    lengths: Sequence[float] = LENGTHS,
    conditioned: bool = False,
) -> WindowLadder:
    """Return a ladder: one model for each window length, trained on these contacts."""
    models = []
    for length in lengths:
        samples = samples_in(length, touches.rate)
        positions = np.flatnonzero(touches.valid >= samples)
        X = windows(touches.take(positions), samples, conditioned)
        good = usable(X)
        X, y = X[good], shore_a[positions[good]]
        sessions = None if groups is None else groups[positions[good]]
        if len(y) >= LEAST:
            models.append(_fitted(learn, X, y, sessions, samples, touches.rate, seed, level))
    if not models:
        raise InputError(
            f"{len(touches)} contacts are too few to learn from: record {LEAST} or more pinches"
        )
    return WindowLadder(models, touches.rate, conditioned)


def _fitted(
    learn: Learn,
    X: Windows,
    y: Values,
    groups: NDArray[np.str_] | None,
    samples: int,
    rate: float,
    seed: int,
    level: float,
) -> _OneLength:
    predicted = np.full(len(y), np.nan)
    for train, ask in inner_folds(y, groups, seed, FOLDS):
        sessions = None if groups is None else groups[train]
        predicted[ask] = _checked(learn(X[train], y[train], sessions, rate, seed)(X[ask]), len(ask))
    has_prediction = np.isfinite(predicted)
    answered = np.clip(predicted[has_prediction], *SHORE_A)
    enough = has_prediction.sum() >= least_answers(level)
    interval = conformal_interval(answered, y[has_prediction], level) if enough else None
    sd = (
        float(np.sqrt(np.mean((answered - y[has_prediction]) ** 2)))
        if has_prediction.any()
        else float(y.std())
    )
    return _OneLength(
        samples, learn(X, y, groups, rate, seed), float(y.mean()), max(sd, 1e-3), interval
    )


def windows(touches: Touches, samples: int, conditioned: bool = False) -> Windows:
    """Return the first samples after each contact, shape (n, samples, 1), V."""
    end = touches.lead + samples
    if not conditioned:
        return touches.signals[:, touches.lead : end, None].copy()
    ahead = SavitzkyGolay().lookahead
    padded = np.pad(touches.signals[:, :end], ((0, 0), (0, ahead)), mode="edge")
    filtered = SavitzkyGolay().update(padded.T.astype(np.float64)).T
    out: Windows = filtered[:, touches.lead : end, None].astype(np.float32)
    return out


def _checked(answers: Values, n: int) -> Values:
    values = np.asarray(answers, dtype=np.float64)
    if values.shape != (n,) or not np.isfinite(values).all():
        finite = "" if np.isfinite(values).all() else ", with values that are no numbers"
        raise InputError(
            f"the regressor predicted {n} windows with an array of shape {values.shape}{finite}: "
            "it must give one finite Shore A value per window"
        )
    return values
