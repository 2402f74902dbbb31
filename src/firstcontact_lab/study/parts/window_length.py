"""Error by the length of the window."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec.structs import replace

from firstcontact.core import Record
from firstcontact.core.jobs import Runner
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.scores import RegressionScores, regression_scores
from firstcontact.models.splits import by_session
from firstcontact.models.training import Question, held_out
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import banded_line, canvas, uri
from firstcontact_lab.report.tables import Bounded, Cell, Row, Table, bounded, matrix
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, titled
from firstcontact_lab.study.parts.objects import object_splits, specimen_names
from firstcontact_lab.study.scores import learns_one_value


class WindowErrors(Record, frozen=True, kw_only=True):
    blocks: RegressionScores | None = None
    objects: RegressionScores | None = None


class WindowSearch(Record, frozen=True, kw_only=True):
    windows: int


def window_length(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
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
    scored = {duration for duration, _ in places}
    missing = [f"{1e3 * d:g}" for d in settings.durations if d not in scored]
    left_out = []
    if missing:
        lengths_text = f" ({', '.join(missing)} ms)" if scored else ""
        left_out.append(
            f"Error against window length{lengths_text}: some training side has windows of fewer "
            "than two Shore A levels."
        )
    if not scored:
        return PartResult(left_out=left_out)
    answers = held_out(runner, questions, settings.seed)
    scores_by_length: dict[str, dict[str, RegressionScores]] = {}
    for (duration, side), question, predicted in zip(places, questions, answers, strict=True):
        data, is_predicted = question.data, np.isfinite(predicted)
        sides = data.take(is_predicted)
        clusters = specimen_names(sides) if side == "objects" else sides.clusters
        scores = regression_scores(sides.y, predicted[is_predicted], clusters, settings.seed)
        scores_by_length.setdefault(f"{1e3 * duration:g}", {})[side] = replace(
            scores, spearman=None
        )
    lengths = {ms: {model: WindowErrors(**sides)} for ms, sides in scores_by_length.items()}
    searched = options.get("search_windows")
    results = [
        WINDOW_LENGTH(lengths),
        WINDOW_SEARCH(None if searched is None else WindowSearch(windows=searched)),
    ]
    return PartResult(results, (), left_out)


def lengths_figure(scores_by_length: Mapping[str, Mapping[str, WindowErrors]]) -> Figure:
    (model,) = names.estimators(next(iter(scores_by_length.values())))
    title = names.estimator(model).title
    with canvas() as (figure, axes):
        ax = axes[0, 0]
        colour = names.estimator(model).colour
        for side, line, name in (
            ("blocks", "o-", "blocks, by session"),
            ("objects", "s--", "unseen objects"),
        ):
            points = [
                (float(ms), scores)
                for ms, sides in scores_by_length.items()
                if model in sides and (scores := getattr(sides[model], side)) is not None
            ]
            if not points:
                continue
            points.sort(key=lambda point: point[0])
            times = [ms for ms, _ in points]
            errors = [bounded(scores, "rmse") or Bounded(scores.rmse) for _, scores in points]
            values, ends = zip(*errors, strict=True)
            banded_line(ax, times, values, ends, line, colour, name)
        ax.set_xticks([float(ms) for ms in scores_by_length])
        ax.set(
            xlabel="Window after contact (ms)", ylabel=f"RMSE (Shore A), {title}", ylim=(0, None)
        )
        ax.set_xlim(0, None)
        ax.legend(loc="best")
        image = uri(figure)
    return Figure(
        f"lengths-{model}",
        f"Error against window length, {title}",
        "Bands are 95 % intervals over sessions or objects.",
        image,
    )


WINDOW_LENGTH = Field.optional("window_length_ms", dict[str, dict[str, WindowErrors]])
WINDOW_SEARCH = Field.optional("window_length_search", WindowSearch)


_ROWS: Sequence[Row[WindowErrors]] = (
    Row("Blocks RMSE", lambda errors: bounded(errors.blocks, "rmse"), "shore"),
    Row("Objects RMSE", lambda errors: bounded(errors.objects, "rmse"), "shore"),
)


def length_table(results: SubjectResults) -> Table | None:
    lengths = results[WINDOW_LENGTH]
    if not lengths:
        return None
    (model,) = names.estimators(next(iter(lengths.values())))
    caption = (
        f"{names.estimator(model).title} regression. Blocks by session, objects unseen; Shore A."
    )
    search = results[WINDOW_SEARCH]
    if search:
        caption += f" Hyper-parameters are searched on up to {search.windows} windows here."
    entries = [(Cell(f"{ms} ms"), lengths[ms][model], False) for ms in sorted(lengths, key=float)]
    return matrix(caption, _ROWS, entries)


PART = Part(
    "length",
    "Window length",
    [Step("window length", window_length, late=True, cost=15)],
    tables=[length_table],
    figures=lambda subjects: titled(subjects, WINDOW_LENGTH, lengths_figure),
)
