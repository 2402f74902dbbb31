"""How much of the window is needed."""

from __future__ import annotations

from typing import Any

import numpy as np

from firstcontact.core.jobs import Runner
from firstcontact.learning.metrics import regression_scores
from firstcontact.learning.splits import by_session, learns_one_value
from firstcontact.learning.training import Question, held_out
from firstcontact.report.figures.lengths import lengths_figure
from firstcontact.report.findings import PartResult
from firstcontact.stiffness import ESTIMATORS, Task
from firstcontact.study._subject import Subject
from firstcontact.study.parts.objects import object_scores, object_splits
from firstcontact.study.settings import StudySettings

KEPT = ("rmse", "mae", "mse", "bias", "n", "intervals")


def window_length(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
    """Error of the default estimator against the length of the window, blocks and objects.

    It learns quickly: there is a training for every length and fold. All lengths are alike.
    """
    questions, places = [], []
    model = ESTIMATORS.default
    options = ESTIMATORS[model].quick
    for duration in settings.durations:
        data = subject.windows(duration)
        blocks = data.take(~data.test)
        if not blocks.has_sessions:
            continue
        folds = by_session(blocks.sessions, blocks.y, settings.seed, settings.folds)
        if learns_one_value(folds, blocks.y):
            continue
        questions.append(Question(model, Task.REGRESSION, blocks, folds, options))
        places.append((duration, "blocks"))
        split = object_splits(subject, data)
        if split:
            questions.append(Question(model, Task.REGRESSION, data, split, options))
            places.append((duration, "objects"))
    done = {duration for duration, _ in places}
    missing = [f"{1e3 * d:g}" for d in settings.durations if d not in done]
    left_out = []
    if missing:
        which = f" ({', '.join(missing)} ms)" if done else ""
        left_out.append(
            f"Error against window length{which}: it needs windows of two Shore A levels to learn "
            "from whichever sessions are held out."
        )
    if not done:
        return PartResult(left_out=left_out)
    answers = held_out(runner, questions, settings.seed)
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
        entry = tree.setdefault(f"{1e3 * duration:g}", {}).setdefault(model, {})
        entry[side] = {key: scores[key] for key in KEPT}
    found: dict[str, Any] = {"window_length_ms": tree}
    if "search_windows" in options:
        found["window_length_search"] = {"windows": options["search_windows"]}
    return PartResult(found, [lengths_figure(model, tree)], left_out)
