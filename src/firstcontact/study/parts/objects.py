"""Regression on objects that no model has seen."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from firstcontact.stiffness.estimator import Task
from firstcontact.study.figures.boxes import boxes_figure
from firstcontact.study.jobs import Runner
from firstcontact.study.metrics import over_objects, per_object, regression_scores
from firstcontact.study.settings import DURATION, Settings
from firstcontact.study.splits import unseen_objects
from firstcontact.study.subject import Outcome, Subject
from firstcontact.study.training import Examples, Question, Values, held_out

#: Under this name objects' predictions are kept for later parts.
UNSEEN = "unseen_objects"


def objects(subject: Subject, settings: Settings, runner: Runner, models: Sequence[str]) -> Outcome:
    """Learn from all pinches of the role ``train``, ask about those of ``test``."""
    reason = _reason(subject)
    if reason:
        return Outcome(left_out=[reason])
    data = subject.windows(DURATION)
    if not data.test.any() or data.test.all():
        return Outcome(left_out=["Unseen objects: no contact was found on one of the two sides."])
    questions = [_question(model, data) for model in models]
    names = [*models]
    aligned = subject.windows(DURATION, subject.truth)
    if subject.found and "svm" in models and aligned.test.any() and not aligned.test.all():
        questions.append(_question("svm", aligned))
        names.append("strip")
    answers = held_out(runner, questions, settings.seed, settings.epochs)
    tree: dict[str, Any] = {}
    for name, question, predicted in zip(names, questions, answers, strict=True):
        scores = object_scores(question.data, predicted, settings.seed)
        if name == "strip":
            tree["svm"]["strip_aligned"] = scores
            continue
        tree[name] = scores
        subject.predictions[name, UNSEEN] = (question.data, predicted)
    figures = [
        boxes_figure(name, *subject.predictions[name, UNSEEN])
        for name in models
        if name in ("svm", "cnn")
    ]
    known = np.isfinite(subject.dataset.shore_a)
    counts = {
        "pinches": int((subject.dataset.test & known).sum()),
        "with_window": int(data.test.sum()),
    }
    return Outcome({"objects": {**tree, "windows": counts}}, figures)


def object_scores(data: Examples, predicted: Values, seed: int) -> dict[str, Any]:
    """Scores per pinch (objects resampled whole) and per object."""
    asked = np.isfinite(predicted)
    its, answers = data.take(asked), predicted[asked]
    names = np.where(its.specimens == "", its.objects, its.specimens)
    scores = regression_scores(its.y, answers, names, seed)
    each = per_object(its.y, answers, names, its.objects)
    return {**scores, "per_object": each, "over_objects": over_objects(each)}


def _question(model: str, data: Examples) -> Question:
    return Question(model, Task.REGRESSION, data, [unseen_objects(data.test)])


def _reason(subject: Subject) -> str:
    known = np.isfinite(subject.dataset.shore_a)
    if not (subject.dataset.test & known).any():
        return "Unseen objects: no pinch has the role `test` and a Shore A."
    if len(subject.levels) < 2:
        return "Unseen objects: fewer than two Shore A levels to learn from."
    shared = set(subject.dataset.specimens[subject.dataset.test]) & set(
        subject.dataset.specimens[~subject.dataset.test]
    )
    if shared:
        name = str(min(shared))
        return f"Unseen objects: the specimen {name!r} has both roles, so it is not unseen."
    sessions = set(subject.dataset.sessions[subject.dataset.test]) & set(
        subject.dataset.sessions[~subject.dataset.test]
    )
    if sessions:
        return f"Unseen objects: the session {str(min(sessions))!r} has pinches of both roles."
    return ""
