"""How much of the window is needed."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.stiffness.estimator import Task
from firstcontact.study.figures.lengths import lengths_figure
from firstcontact.study.jobs import Runner
from firstcontact.study.metrics import regression_scores
from firstcontact.study.parts.objects import object_scores
from firstcontact.study.settings import Settings
from firstcontact.study.splits import by_session, unseen_objects
from firstcontact.study.subject import Outcome, Subject
from firstcontact.study.training import Question, held_out

KEPT = ("rmse", "mae", "mse", "bias", "n", "intervals")


def window_length(subject: Subject, settings: Settings, runner: Runner) -> Outcome:
    """SVM regression error against the length of the window, blocks and objects."""
    if len(subject.levels) < 2 or not subject.has_sessions:
        return Outcome(
            left_out=[
                "Error against window length: it needs two Shore A levels in two sessions or more."
            ]
        )
    questions, places = [], []
    for duration in settings.durations:
        data = subject.windows(duration)
        blocks = data.take(~data.test)
        folds = by_session(blocks.sessions, blocks.y, settings.seed, settings.folds)
        questions.append(Question("svm", Task.REGRESSION, blocks, folds))
        places.append((duration, "blocks"))
        if data.test.any():
            split = [unseen_objects(data.test)]
            questions.append(Question("svm", Task.REGRESSION, data, split))
            places.append((duration, "objects"))
    answers = held_out(runner, questions, settings.seed, settings.epochs)
    tree: dict[str, Any] = {}
    for (duration, side), question, predicted in zip(places, questions, answers, strict=True):
        data, asked = question.data, np.isfinite(predicted)
        scores = (
            object_scores(data, predicted, settings.seed)
            if side == "objects"
            else regression_scores(
                data.y[asked], predicted[asked], data.clusters[asked], settings.seed
            )
        )
        entry = tree.setdefault(f"{1e3 * duration:g}", {}).setdefault("svm", {})
        entry[side] = {key: scores[key] for key in KEPT}
    return Outcome({"window_length_ms": tree}, [lengths_figure(tree)])
