"""Held-out predictions of window models, and the training of the final model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import exp
from typing import Any

import numpy as np

from firstcontact.core import ArgumentError
from firstcontact.core.quantity import SHORE_A, Quantity
from firstcontact.core.text import counted, percent
from firstcontact.jobs import Runner
from firstcontact.models.interval import (
    Interval,
    conformal_interval,
    held_out_coverage,
    missing_interval_reason,
)
from firstcontact.models.labelled_data import LabelledWindows
from firstcontact.models.registry import ESTIMATORS, find_estimator, make_estimator
from firstcontact.models.scores import (
    ClassificationScores,
    TaskScores,
    classification_scores,
    regression_scores,
)
from firstcontact.models.splits import Group, Split, by_session, inner_folds
from firstcontact.models.values import Task, Values
from firstcontact.models.windows.window_model import WindowModel


def fit_model(
    learn: LabelledWindows, model: object, task: Task, seed: int, options: Mapping[str, Any]
) -> WindowModel:
    """Fit an estimator to labelled windows. ``model`` names it, see :func:`make_estimator`.

    ``options`` set fields of the estimator.
    """
    return fit_models([learn], model, task, seed, options)[0]


def fit_models(
    sets: Sequence[LabelledWindows],
    model: object,
    task: Task,
    seed: int,
    options: Mapping[str, Any],
) -> Sequence[WindowModel]:
    """Fit an estimator to each of several sets of windows. Return one model per set.

    The other parameters are those of :func:`fit_model`. Raise TypeError if the estimator returns
    something other than such models.
    """
    estimator = make_estimator(model, task, sets[0].rate, **options)
    with ESTIMATORS.convert_errors(estimator.name):
        models = list(
            estimator.fit_several([(s.X, s.y, s.named_sessions) for s in sets], seed=seed)
        )
        if len(models) != len(sets):
            raise TypeError(
                f"fit_several made {len(models)} models, not {len(sets)}: return one per set"
            )
        for fitted in models:
            if not isinstance(fitted, WindowModel):
                raise TypeError(f"fit made a {type(fitted).__name__}: return a WindowModel")
    return models


@dataclass(frozen=True, slots=True, eq=False)
class Question:
    """Predictions to compute for held-out windows, with one estimator.

    ``model`` names the estimator, and ``options`` set its fields. ``splits`` state which windows of
    ``data`` it is fitted to, and which it predicts.
    """

    model: object
    task: Task
    data: LabelledWindows
    splits: Sequence[Split]
    options: Mapping[str, Any] = field(default_factory=dict)


def held_out(runner: Runner, questions: Sequence[Question], seed: int) -> list[Values]:
    """Predict each window with a model that was not fitted to it. Return one array per question.

    Windows that no split holds out have NaN.
    """
    return [answers for answers, _ in held_out_with_spread(runner, questions, seed)]


def held_out_with_spread(
    runner: Runner, questions: Sequence[Question], seed: int
) -> list[tuple[Values, Values | None]]:
    """Predict as :func:`held_out`. Return predictions and standard deviations for each question.

    Standard deviations are None if a model predicts none.
    """
    jobs = []
    for number, question in enumerate(questions):
        for split in question.splits:
            split.check(question.data.sessions, question.data.specimens)
        # Weights depend on which sets train together, so jobs do not depend on the number of
        # workers.
        places, size = range(len(question.splits)), find_estimator(question.model).together
        jobs += [(number, places[i : i + size]) for i in range(0, len(places), size)]
    # Read-only views of mappings, as estimators declare them, cannot be pickled.
    plain = [replace(question, options=dict(question.options)) for question in questions]
    answers = runner.map(_predict_held_out, jobs, plain, seed)
    out = [np.full((2, len(q.data)), np.nan) for q in questions]
    has_spread = dict.fromkeys(range(len(questions)), True)
    for (number, places), by_place in zip(jobs, answers, strict=True):
        for place, (predicted, spread) in zip(places, by_place, strict=True):
            test_rows = questions[number].splits[place].test
            out[number][0, test_rows] = predicted
            has_spread[number] &= spread is not None
            out[number][1, test_rows] = np.nan if spread is None else spread
    return [
        (predictions[0], predictions[1] if has_spread[number] else None)
        for number, predictions in enumerate(out)
    ]


def _predict_held_out(
    job: tuple[int, range], questions: Sequence[Question], seed: int
) -> list[tuple[Values, Values | None]]:
    """Fit models without some of the windows, and predict these held-out windows.

    ``job`` holds the index of one of the ``questions`` (model and data to score), and the indices
    of some of its splits. Return a pair for each split: predictions, and standard deviations or
    None.
    """
    question = questions[job[0]]
    splits, data = [question.splits[place] for place in job[1]], question.data
    sets = [data.take(split.train) for split in splits]
    models = fit_models(sets, question.model, question.task, seed, question.options)
    asked = [data.X[split.test] for split in splits]
    return [(m.predict(X), m.spread(X)) for m, X in zip(models, asked, strict=True)]


#: Smallest number of pinches for training and held-out scores.
LEAST = 10


@dataclass(frozen=True, slots=True, eq=False)
class FinalModel:
    """Model that is fitted to all windows, with the scores of held-out predictions.

    ``split`` describes in words how windows were held out. ``conformal`` holds the coverage of
    ``interval`` on held-out windows, or under "none" the reason why there is no interval.
    """

    model: WindowModel
    scores: TaskScores
    split: str
    interval: Interval | None
    conformal: Mapping[str, Any]


def train_final_model(
    data: LabelledWindows,
    model: object,
    task: Task,
    seed: int,
    level: float,
    runner: Runner,
    limits: tuple[float, float] | None = SHORE_A.limits,
) -> FinalModel:
    """Fit an estimator to all windows, and score it on held-out windows.

    ``level`` is the nominal coverage of its interval, and ``limits`` are the ends of the scale.
    Raise ArgumentError if there are too few windows, or all have one label.
    """
    if len(data) < LEAST:
        raise ArgumentError(
            f"{len(data)} labelled pinches are too few to train a model and to score it: record "
            f"{LEAST} or more",
            parameter="data",
        )
    levels = np.unique(data.y)
    if len(levels) < 2:
        raise ArgumentError(
            f"all {len(data)} usable pinches have the label {levels[0]:g}: record pinches of "
            "another object",
            parameter="data",
        )
    estimator = find_estimator(model)
    splits, words = _splits(data, estimator.folds, seed)
    question = Question(model, task, data, splits)
    answers, spreads = held_out_with_spread(runner, [question], seed)[0]
    [final] = runner.map(fit_model, [data], model, task, seed, {})
    has_prediction = np.isfinite(answers)
    data, answers = data.take(has_prediction), answers[has_prediction]
    spreads = None if spreads is None else spreads[has_prediction]
    score: Callable[..., TaskScores] = (
        regression_scores if task == Task.REGRESSION else classification_scores
    )
    scores = score(data.y, answers, data.bootstrap_clusters, seed)
    reason = (
        missing_interval_reason(data.y, data.sessions, level)
        if task == Task.REGRESSION
        else "a classification predicts one of its classes"
    )
    interval: Interval | None = None
    conformal: dict[str, Any] = {"none": reason}
    if not reason:
        folds = np.zeros(len(has_prediction), dtype=np.intp)
        for number, split in enumerate(splits):
            folds[split.test] = number
        folds = folds[has_prediction]
        interval = conformal_interval(answers, data.y, level, limits, spreads)
        conformal = {
            "pinches": len(data),
            "sessions": len(np.unique(data.sessions)),
            "folds": len(splits),
            "held_out": held_out_coverage(answers, data.y, folds, level, limits, spreads),
        }
    return FinalModel(final, scores, words, interval, conformal)


def _splits(data: LabelledWindows, folds: int, seed: int) -> tuple[list[Split], str]:
    """Return splits that hold out whole sessions, and a text that describes them.

    Without two named sessions, a single split holds out a random fifth of the windows.
    """
    if data.has_sessions:
        splits = by_session(data.sessions, data.y, seed, folds)
        words = f"{len(np.unique(data.sessions))} sessions in {len(splits)} folds"
    else:
        learn, ask = next(inner_folds(data.y, None, seed, k=5))
        shares = frozenset({Group.SESSION, Group.SPECIMEN})
        splits = [Split("random fifth", learn, ask, shares)]
        words = "random pinches; without two known sessions the scores are too good"
    usable = [split for split in splits if len(np.unique(data.y[split.train])) > 1]
    if not usable:
        raise ArgumentError(
            "whichever session is held out, the others have only one label or class: record "
            "every object in two sessions or more",
            parameter="data",
        )
    if left := len(splits) - len(usable):
        words += f"; {counted(left, 'fold')} not scored: only one label or class is left"
    splits = usable
    if any(np.setdiff1d(data.y[split.test], data.y[split.train]).size for split in splits):
        words += "; a level of one fold alone is predicted without having been learned"
    return splits, words


def scores_in_words(scores: TaskScores, quantity: Quantity) -> str:
    """Return scores as a line of text, with errors in the unit of the quantity or as factors."""
    pinches, words = counted(scores.n, "pinch"), quantity.error_words
    if isinstance(scores, ClassificationScores):
        return f"accuracy {percent(scores.accuracy)}, {pinches}"
    square = f", mse {words(scores.mse)}²"
    if quantity.is_logarithmic:
        words, square = (lambda error: f"factor {exp(error):.2f}"), ""
    return (
        f"rmse {words(scores.rmse)}, mae {words(scores.mae)}{square}, bias {words(scores.bias)}, "
        f"{pinches}"
    )


def interval_in_words(final: FinalModel, quantity: Quantity) -> str:
    """Return the width of an interval and its coverage on held-out windows as one line of text."""
    if final.interval is None:
        return f"the model has no interval, because {final.conformal['none']}"
    checked = final.conformal["held_out"]
    if not checked:
        return f"the interval at level {final.interval.level:g} was not checked: too few pinches"
    return (
        f"the interval at level {final.interval.level:g} held the truth in "
        f"{percent(checked['coverage'])} of {checked['n']} pinches of held-out folds, mean width "
        f"{quantity.width_words(checked['mean_width'])}"
    )
