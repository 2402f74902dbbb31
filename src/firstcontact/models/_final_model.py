"""Final model: fitted to all examples, with scores and an interval from held-out folds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from firstcontact.core import InputError, Runner, counted, percent
from firstcontact.models._conformal import conformal_interval, coverage, held_out_bounds, refusal
from firstcontact.models._interval import SHORE_A, Interval
from firstcontact.models._metrics import classification_scores, regression_scores
from firstcontact.models._registry import find_estimator
from firstcontact.models._scores import TaskScores
from firstcontact.models._spec import Task, Values
from firstcontact.models._splits import Group, Split, by_session, inner_folds
from firstcontact.models._training import (
    Fit,
    LabelledWindows,
    Question,
    fit_model,
    held_out_with_spread,
)
from firstcontact.models._window_model import WindowModel

Target = Literal["shore_a", "hardness_rank"]
#: Unit of the errors of each target.
UNITS: dict[Target, str] = {"shore_a": "Shore A", "hardness_rank": "ranks"}
#: Smallest number of pinches for training and held-out scores.
LEAST = 10


@dataclass(frozen=True, slots=True, eq=False)
class FinalModel:
    """Trained model with its held-out scores and its interval.

    Parameters
    ----------
    model
        Model that is fitted to all examples.
    scores
        Scores of models of the same type on folds that were held out of training.
    split
        Description of the folds.
    interval
        Interval from the predictions that also give the scores; None without one.
    conformal
        Description of the calibration of the interval, for the card.
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
    shore: bool = True,
) -> FinalModel:
    """Train a model on all examples, with held-out scores and an interval.

    Parameters
    ----------
    data
        Training data.
    model
        Name of an estimator, or a regressor with scikit-learn's interface.
    task
        Regression or classification.
    seed
        Random seed of the folds, the search and the training.
    level
        Coverage of the interval of a regression.
    runner
        Runner for the trainings.
    shore
        True if the target is Shore A, whose scale has ends.

    Raises
    ------
    InputError
        There are too few examples, or all have the same target, possibly whatever sessions are
        held out.
    """
    if len(data) < LEAST:
        raise InputError(
            f"{len(data)} labelled pinches are too few to train a model and to score it: record "
            f"{LEAST} or more"
        )
    levels = np.unique(data.y)
    if len(levels) < 2:
        raise InputError(
            f"all {len(data)} usable pinches have the label {levels[0]:g}: record pinches of "
            "another object",
            parameter="data",
        )
    estimator = find_estimator(model)
    splits, words = _splits(data, estimator.folds, seed)
    question = Question(model, task, data, splits)
    answers, spreads = held_out_with_spread(runner, [question], seed)[0]
    [final] = runner.map(fit_model, [Fit(model, task, data, data.X[:0], seed)])
    has_prediction = np.isfinite(answers)
    data, answers = data.take(has_prediction), answers[has_prediction]
    spreads = None if spreads is None else spreads[has_prediction]
    scores = _score(task, data, answers, seed)
    interval, conformal = None, _none(data, task, level)
    if not conformal:
        limits = SHORE_A if shore else None
        folds = np.zeros(len(has_prediction), dtype=np.intp)
        for number, split in enumerate(splits):
            folds[split.test] = number
        folds = folds[has_prediction]
        interval = conformal_interval(answers, data.y, level, limits, spreads)
        tested = held_out_bounds(answers, data.y, folds, level, limits, spreads)
        conformal = {
            "pinches": len(data),
            "sessions": len(np.unique(data.sessions)),
            "folds": len(splits),
            "held_out": coverage(tested, answers, data.y, spreads),
        }
    return FinalModel(final, scores, words, interval, conformal)


def _none(data: LabelledWindows, task: Task, level: float) -> dict[str, Any]:
    """Return the reason why the model has no interval as ``none``; empty if it has one."""
    if task is Task.CLASSIFICATION:
        return {"none": "a classification predicts one of its classes"}
    why = refusal(data.y, data.sessions, level)
    return {"none": why} if why else {}


def _splits(data: LabelledWindows, folds: int, seed: int) -> tuple[list[Split], str]:
    """Return folds that hold out whole sessions, and their description."""
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
        raise InputError(
            "if any pinches are held out, those left to learn from have a single level: record "
            "each object in two sessions or more",
            parameter="data",
        )
    if left := len(splits) - len(usable):
        words += f"; {counted(left, 'fold')} not scored: a single level is left to learn from"
    splits = usable
    if any(np.setdiff1d(data.y[split.test], data.y[split.train]).size for split in splits):
        words += "; a level of one fold alone is predicted without having been learned"
    return splits, words


def _score(task: str, data: LabelledWindows, answers: Values, seed: int) -> TaskScores:
    """Return the scores of the held-out predictions."""
    of: Callable[..., TaskScores] = (
        regression_scores if task == "regression" else classification_scores
    )
    return of(data.y, answers, data.clusters, seed)


def scores_in_words(scores: TaskScores, target: Target) -> str:
    """Return scores as one line of text, errors in the unit of the target."""
    unit = UNITS[target]
    units = {"rmse": unit, "mae": unit, "mse": f"{unit}²", "bias": unit}
    numbers = [
        f"{name} {value:.2f} {unit}"
        for name, unit in units.items()
        if (value := getattr(scores, name, None)) is not None
    ]
    if (accuracy := getattr(scores, "accuracy", None)) is not None:
        numbers.insert(0, f"accuracy {percent(accuracy)}")
    return f"{', '.join(numbers)}, {counted(scores.n, 'pinch')}"


def interval_in_words(final: FinalModel, target: Target) -> str:
    """Format the interval and its held-out coverage on one line."""
    if final.interval is None:
        return f"no interval: {final.conformal['none']}"
    checked = final.conformal["held_out"]
    if not checked:
        return f"interval at level {final.interval.level:g}: too few pinches to check it on"
    return (
        f"held out, interval from other folds: the interval at level {final.interval.level:g} "
        f"held the truth in {percent(checked['coverage'])} of {checked['n']} pinches, mean "
        f"width {checked['mean_width']:.1f} {UNITS[target]}"
    )
