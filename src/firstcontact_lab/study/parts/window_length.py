"""How much of the window is needed."""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from firstcontact.core import Runner
from firstcontact.models import (
    ESTIMATORS,
    Question,
    RegressionScores,
    Task,
    by_session,
    held_out,
    learns_one_value,
    regression_scores,
)
from firstcontact_lab.report.figures.lengths import lengths_figure
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.stiffness import WindowErrors, WindowSearch
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.objects import object_splits, things
from firstcontact_lab.study.settings import StudySettings


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
    found: dict[str, dict[str, RegressionScores]] = {}
    for (duration, side), question, predicted in zip(places, questions, answers, strict=True):
        data, asked = question.data, np.isfinite(predicted)
        its = data.take(asked)
        clusters = things(its) if side == "objects" else its.clusters
        scores = regression_scores(its.y, predicted[asked], clusters, settings.seed)
        found.setdefault(f"{1e3 * duration:g}", {})[side] = replace(scores, spearman=None)
    lengths = {ms: {model: WindowErrors(**its)} for ms, its in found.items()}
    searched = options.get("search_windows")
    results = SubjectResults(
        window_length_ms=lengths,
        window_length_search=None if searched is None else WindowSearch(windows=searched),
    )
    return PartResult(results, [lengths_figure(model, lengths)], left_out)
