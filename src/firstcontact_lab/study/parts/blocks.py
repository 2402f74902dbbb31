"""Discrimination and regression on the pinches to learn from, in every split."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from msgspec.structs import asdict, replace

from firstcontact.core import ByName, Runner
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    LabelledWindows,
    Question,
    RegressionScores,
    Split,
    Task,
    TaskScores,
    Values,
    by_session,
    classification_scores,
    held_out,
    learns_one_value,
    leave_one_out,
    never_learned,
    random_90_10,
    regression_scores,
)
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.confusion import confusion_figure
from firstcontact_lab.report.figures.levels import leave_one_out_figure
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results.stiffness import (
    BlockConditions,
    BlockScores,
    SplitScores,
    WindowCounts,
)
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

#: Splits in the order of the report.
RANDOM, SESSION, LEVEL = "random_90_10", "by_session", "leave_one_shore_out"

Splits = dict[tuple[str, Task], list[Split]]


def blocks(
    subject: Subject, settings: StudySettings, runner: Runner, models: Sequence[str]
) -> PartResult:
    """Score these models in the random split, by session, and with a level left out.

    The default estimator is scored at the strip-aligned contact as well, where that is known.
    """
    if len(subject.levels) < 2:
        return PartResult(
            left_out=[
                "Shore A discrimination and regression: the pinches to learn from have fewer "
                "than two known Shore A levels."
            ]
        )
    data = _learnable(subject, subject.windows(DURATION))
    splits, left_out = _splits(data, settings)
    questions, places = _questions(data, splits, models, settings)
    aligned = _learnable(subject, subject.windows(DURATION, subject.truth))
    reference = ESTIMATORS.default
    strip = bool(subject.found) and reference in models and len(aligned) > 0
    if strip:
        # Leaving a level out is about levels, not about alignment: the two pinch splits do.
        strip_splits = {
            place: folds
            for place, folds in _splits(aligned, settings)[0].items()
            if place[0] != LEVEL
        }
        more, more_places = _questions(aligned, strip_splits, [reference], settings)
        questions += more
        places += [("strip", split, task) for _, split, task in more_places]
    answers = held_out(runner, questions, settings.seed)
    by_split: dict[str, dict[str, dict[str, Any]]] = {}
    for (model, split, task), question, predicted in zip(places, questions, answers, strict=True):
        scores = _scores(question.data, predicted, task, settings.seed)
        entry = by_split.setdefault(model, {}).setdefault(split, {"intervals": {}})
        entry |= {**asdict(scores), "intervals": {**entry["intervals"], **scores.intervals}}
        if task is Task.REGRESSION and model != "strip":
            subject.predictions[model, split] = (question.data, predicted)
            if split == LEVEL:
                entry["per_level"] = _per_level(question.data, predicted, settings.seed)
    found = {}
    for model, its in by_split.items():
        splits_of: dict[str, Any] = {split: SplitScores(**entry) for split, entry in its.items()}
        found[model] = BlockScores(**splits_of)
    if "strip" in found:
        found[reference] = replace(found[reference], strip_aligned=found.pop("strip"))
    total = int((~subject.dataset.test & np.isfinite(subject.dataset.shore_a)).sum())
    about = BlockConditions(windows=WindowCounts(pinches=total, with_window=len(data)))
    results = SubjectResults(blocks=ByName(found, about))
    return PartResult(results, _figures(subject, found), left_out)


def _learnable(subject: Subject, data: LabelledWindows) -> LabelledWindows:
    return data.take(~data.test & np.isin(data.y, subject.levels))


def _splits(data: LabelledWindows, settings: StudySettings) -> tuple[Splits, list[str]]:
    """What these windows permit, and why not the rest."""
    counts = np.unique(data.y, return_counts=True)[1]
    out: Splits = {}
    left_out = []
    if len(counts) >= 2 and counts.min() >= 2 and len(data) >= 10 * len(counts):
        folds = random_90_10(data.y, settings.seed)
        out[RANDOM, Task.CLASSIFICATION] = out[RANDOM, Task.REGRESSION] = folds
    else:
        left_out.append("Random 90/10 split: too few pinches for ten a level.")
    if data.has_sessions:
        folds = by_session(data.sessions, data.y, settings.seed, settings.folds)
        if learns_one_value(folds, data.y):
            left_out.append(
                "Split by session: with some sessions held out, a single Shore A level is left to "
                "learn from."
            )
        else:
            out[SESSION, Task.REGRESSION] = folds
            unknown = never_learned(folds, data.y)
            if len(unknown):
                left_out.append(_one_session(unknown, data))
            else:
                out[SESSION, Task.CLASSIFICATION] = folds
    else:
        left_out.append("Split by session: the windows do not lie in two named sessions.")
    if len(counts) >= 3:
        out[LEVEL, Task.REGRESSION] = leave_one_out(data.y)
    else:
        left_out.append("Leaving one Shore level out: there are fewer than three levels.")
    return out, left_out


def _one_session(levels: Values, data: LabelledWindows) -> str:
    alone = all(len(np.unique(data.sessions[data.y == level])) == 1 for level in levels)
    where = "in one session each" if alone else "in sessions that are held out together"
    return (
        f"Discrimination by session: the levels {', '.join(f'{v:g}' for v in levels)} lie {where}, "
        "so no model could have learned them before it is asked about them."
    )


def _questions(
    data: LabelledWindows, splits: Splits, models: Sequence[str], settings: StudySettings
) -> tuple[list[Question], list[tuple[str, str, Task]]]:
    questions, places = [], []
    for (name, task), folds in splits.items():
        for model in models:
            if task in ESTIMATORS[model].tasks:
                questions.append(Question(model, task, data, folds, settings.options(model)))
                places.append((model, name, task))
    return questions, places


def _scores(data: LabelledWindows, predicted: Values, task: Task, seed: int) -> TaskScores:
    asked = np.isfinite(predicted)
    truth, clusters = data.y[asked], data.clusters[asked]
    score: Callable[..., TaskScores] = (
        classification_scores if task is Task.CLASSIFICATION else regression_scores
    )
    return score(truth, predicted[asked], clusters, seed)


def _per_level(data: LabelledWindows, predicted: Values, seed: int) -> dict[str, RegressionScores]:
    return {
        f"{level:g}": regression_scores(
            data.y[data.y == level],
            predicted[data.y == level],
            data.clusters[data.y == level],
            seed,
        )
        for level in np.unique(data.y)
    }


def _figures(subject: Subject, found: Mapping[str, BlockScores]) -> list[Figure]:
    told = any(its.by_session and its.by_session.confusion for its in found.values())
    split = SESSION if told else RANDOM
    figures = [
        confusion_figure(model, split, scores)
        for model in names.estimators(found)
        if (scores := found[model].split(split)) and scores.confusion
    ]
    drawn = {
        model: subject.predictions[model, LEVEL]
        for model in names.estimators(ESTIMATORS)
        if (model, LEVEL) in subject.predictions
    }
    if drawn:
        figures.append(leave_one_out_figure(drawn))
    return figures
