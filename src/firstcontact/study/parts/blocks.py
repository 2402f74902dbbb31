"""Discrimination and regression on the pinches to learn from, in every split."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from firstcontact.stiffness.estimator import Task
from firstcontact.study.figures.confusion import confusion_figure
from firstcontact.study.figures.levels import leave_one_out_figure
from firstcontact.study.jobs import Runner
from firstcontact.study.metrics import classification_scores, regression_scores
from firstcontact.study.settings import DURATION, Settings
from firstcontact.study.splits import Split, by_session, leave_one_out, random_90_10
from firstcontact.study.subject import Figure, Outcome, Subject
from firstcontact.study.training import Examples, Question, Values, held_out

#: Splits in the order of the report.
RANDOM, SESSION, LEVEL = "random_90_10", "by_session", "leave_one_shore_out"


def blocks(subject: Subject, settings: Settings, runner: Runner, models: Sequence[str]) -> Outcome:
    """Score these models in the random split, by session, and with a level left out.

    The SVM is scored at the strip-aligned contact as well, where that is known.
    """
    if len(subject.levels) < 2:
        return Outcome(
            left_out=[
                "Shore A discrimination and regression: the pinches to learn from have fewer "
                "than two known Shore A levels."
            ]
        )
    data = _learnable(subject, subject.windows(DURATION))
    splits = _splits(subject, data, settings)
    left_out = _why_left_out(subject, splits)
    questions, places = _questions(data, splits, models)
    aligned = _learnable(subject, subject.windows(DURATION, subject.truth))
    strip = bool(subject.found) and "svm" in models and len(aligned) > 0
    if strip:
        # Leaving a level out is about levels, not about alignment: the two pinch splits do.
        strip_splits = _splits(subject, aligned, settings)
        strip_splits.pop(LEVEL, None)
        more, more_places = _questions(aligned, strip_splits, ["svm"])
        questions += more
        places += [("strip", split, task) for _, split, task in more_places]
    answers = held_out(runner, questions, settings.seed, settings.epochs)
    tree: dict[str, Any] = {}
    for (model, split, task), question, predicted in zip(places, questions, answers, strict=True):
        home = tree.setdefault("svm" if model == "strip" else model, {})
        if model == "strip":
            home = home.setdefault("strip_aligned", {})
        scores = _scores(question.data, predicted, task, settings.seed)
        entry = home.setdefault(split, {})
        intervals = {**entry.get("intervals", {}), **scores["intervals"]}
        entry.update(scores, intervals=intervals)
        if task is Task.REGRESSION and model != "strip":
            subject.predictions[model, split] = (question.data, predicted)
            if split == LEVEL:
                entry["per_level"] = _per_level(question.data, predicted, settings.seed)
    total = int((~subject.dataset.test & np.isfinite(subject.dataset.shore_a)).sum())
    counts = {"pinches": total, "with_window": len(data)}
    return Outcome({"blocks": {**tree, "windows": counts}}, _figures(subject, tree), left_out)


def _learnable(subject: Subject, data: Examples) -> Examples:
    return data.take(~data.test & np.isin(data.y, subject.levels))


def _splits(subject: Subject, data: Examples, settings: Settings) -> dict[str, list[Split]]:
    counts = np.unique(data.y, return_counts=True)[1]
    out: dict[str, list[Split]] = {}
    if len(counts) >= 2 and counts.min() >= 2 and len(data) >= 10 * len(counts):
        out[RANDOM] = random_90_10(data.y, settings.seed)
    if subject.has_sessions and len(np.unique(data.sessions)) > 1:
        out[SESSION] = by_session(data.sessions, data.y, settings.seed, settings.folds)
    if len(counts) >= 3:
        out[LEVEL] = leave_one_out(data.y)
    return out


def _why_left_out(subject: Subject, splits: dict[str, list[Split]]) -> list[str]:
    reasons = {
        RANDOM: "Random 90/10 split: too few pinches for ten a level.",
        SESSION: "Split by session: the pinches do not name two sessions.",
        LEVEL: "Leaving one Shore level out: there are fewer than three levels.",
    }
    return [reason for name, reason in reasons.items() if name not in splits]


def _questions(
    data: Examples, splits: dict[str, list[Split]], models: Sequence[str]
) -> tuple[list[Question], list[tuple[str, str, Task]]]:
    questions, places = [], []
    for name, folds in splits.items():
        for task in (Task.CLASSIFICATION, Task.REGRESSION):
            if name == LEVEL and task is Task.CLASSIFICATION:
                continue
            for model in models:
                questions.append(Question(model, task, data, folds))
                places.append((model, name, task))
    return questions, places


def _scores(data: Examples, predicted: Values, task: Task, seed: int) -> dict[str, Any]:
    asked = np.isfinite(predicted)
    truth, clusters = data.y[asked], data.clusters[asked]
    score = classification_scores if task is Task.CLASSIFICATION else regression_scores
    return score(truth, predicted[asked], clusters, seed)


def _per_level(data: Examples, predicted: Values, seed: int) -> dict[str, Any]:
    return {
        f"{level:g}": regression_scores(
            data.y[data.y == level],
            predicted[data.y == level],
            data.clusters[data.y == level],
            seed,
        )
        for level in np.unique(data.y)
    }


def _figures(subject: Subject, tree: dict[str, Any]) -> list[Figure]:
    split = SESSION if any(SESSION in scores for scores in tree.values()) else RANDOM
    figures = [
        confusion_figure(model, split, tree[model][split])
        for model in ("svm", "cnn")
        if split in tree.get(model, {})
    ]
    drawn = {
        model: subject.predictions[model, LEVEL]
        for model in ("svm", "cnn")
        if (model, LEVEL) in subject.predictions
    }
    if drawn:
        figures.append(leave_one_out_figure(drawn))
    return figures
