"""Study part ``blocks``: accuracy of predicted Shore A on flat blocks, in every split."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from msgspec.structs import asdict, replace

from firstcontact.core import Record
from firstcontact.core.display import INK
from firstcontact.core.installation import missing_modules
from firstcontact.core.records import ByName
from firstcontact.core.text import percent
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.labelled_data import DURATION, LabelledWindows
from firstcontact.models.registry import window_estimators
from firstcontact.models.scores import (
    Ends,
    RegressionScores,
    TaskScores,
    classification_scores,
    regression_scores,
)
from firstcontact.models.splits import Split, by_session, leave_one_out
from firstcontact.models.training import Question, held_out
from firstcontact.models.values import Values
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import box_figure, canvas, uri
from firstcontact_lab.report.tables import (
    ABSENT,
    SHARE_TOLERANCE,
    Cell,
    Claim,
    Row,
    Table,
    bounded,
    matrix,
    row_for_results,
)
from firstcontact_lab.study.part import Part, Step, StudySettings, Subject, Subjects, distinct
from firstcontact_lab.study.parts.contacts import is_learned
from firstcontact_lab.study.scores import learns_one_value, never_learned, random_90_10


class WindowCounts(Record, frozen=True, kw_only=True):
    pinches: int
    with_window: int


class SplitScores(Record, frozen=True, kw_only=True):
    """Scores of one estimator in one split. A score that was not measured is None."""

    rmse: float | None = None
    mae: float | None = None
    mse: float | None = None
    bias: float | None = None
    n: int
    spearman: float | None = None
    accuracy: float | None = None
    classes: list[float] | None = None
    confusion: list[list[int]] | None = None
    intervals: dict[str, Ends]
    per_level: dict[str, RegressionScores] | None = None


class BlockScores(Record, frozen=True, kw_only=True):
    random_90_10: SplitScores | None = None
    by_session: SplitScores | None = None
    leave_one_shore_out: SplitScores | None = None
    strip_aligned: BlockScores | None = None

    def split(self, name: str) -> SplitScores | None:
        scores_by_model: SplitScores | None = getattr(self, name)
        return scores_by_model


class BlockConditions(Record, frozen=True, kw_only=True):
    windows: WindowCounts | None = None


BlockResults = ByName[BlockScores, BlockConditions]


RANDOM, SESSION, LEVEL = "random_90_10", "by_session", "leave_one_shore_out"


Splits = dict[tuple[str, Task], list[Split]]


def blocks(
    subject: Subject, settings: StudySettings, runner: Runner, models: Sequence[str]
) -> PartResult:
    if len(subject.levels) < 2:
        return missing(
            "Shore A discrimination and regression: the pinches to learn from have fewer "
            "than two known Shore A levels."
        )
    data = _learnable(subject, subject.windows(DURATION))
    splits, left_out = _splits(data, settings)
    questions, places = _questions(data, splits, models, settings)
    aligned = _learnable(subject, subject.windows(DURATION, subject.truth))
    reference = ESTIMATORS.default
    strip = bool(subject.detections) and reference in models and len(aligned) > 0
    if strip:
        # The effect of windows that start at known contacts is measured in the other two splits
        # only.
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
    scores_by_model = {}
    for model, split_scores in by_split.items():
        splits_of: dict[str, Any] = {
            split: SplitScores(**entry) for split, entry in split_scores.items()
        }
        scores_by_model[model] = BlockScores(**splits_of)
    if "strip" in scores_by_model:
        scores_by_model[reference] = replace(
            scores_by_model[reference], strip_aligned=scores_by_model.pop("strip")
        )
    total = int((~subject.dataset.test & np.isfinite(subject.dataset.shore_a)).sum())
    about = BlockConditions(windows=WindowCounts(pinches=total, with_window=len(data)))
    results = [BLOCKS(ByName(scores_by_model, about))]
    return PartResult(results, _figures(subject, scores_by_model), left_out)


def _learnable(subject: Subject, data: LabelledWindows) -> LabelledWindows:
    return data.take(~data.test & np.isin(data.y, subject.levels))


def _splits(data: LabelledWindows, settings: StudySettings) -> tuple[Splits, list[str]]:
    counts = np.unique(data.y, return_counts=True)[1]
    out: Splits = {}
    left_out = []
    if len(counts) >= 2 and counts.min() >= 2 and len(data) >= 10 * len(counts):
        folds = random_90_10(data.y, settings.seed)
        out[RANDOM, Task.CLASSIFICATION] = out[RANDOM, Task.REGRESSION] = folds
    else:
        left_out.append("Random 90/10 split: some level has fewer than ten pinches.")
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
        left_out.append("Split by session: the windows are not from two or more named sessions.")
    if len(counts) >= 3:
        out[LEVEL, Task.REGRESSION] = leave_one_out(data.y)
    else:
        left_out.append("Leaving one Shore level out: there are fewer than three levels.")
    return out, left_out


def _one_session(levels: Values, data: LabelledWindows) -> str:
    alone = all(len(np.unique(data.sessions[data.y == level])) == 1 for level in levels)
    interval_place = "in one session each" if alone else "in sessions that are held out together"
    return (
        f"Discrimination by session: the levels {', '.join(f'{v:g}' for v in levels)} lie "
        f"{interval_place}, "
        "so no model could be trained on them before it predicts them."
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
    is_predicted = np.isfinite(predicted)
    truth, clusters = data.y[is_predicted], data.bootstrap_clusters[is_predicted]
    score: Callable[..., TaskScores] = (
        classification_scores if task is Task.CLASSIFICATION else regression_scores
    )
    return score(truth, predicted[is_predicted], clusters, seed)


def _per_level(data: LabelledWindows, predicted: Values, seed: int) -> dict[str, RegressionScores]:
    return {
        f"{level:g}": regression_scores(
            data.y[data.y == level],
            predicted[data.y == level],
            data.bootstrap_clusters[data.y == level],
            seed,
        )
        for level in np.unique(data.y)
    }


def _figures(subject: Subject, scores_by_model: Mapping[str, BlockScores]) -> list[Figure]:
    has_classes = any(
        split_scores.by_session and split_scores.by_session.confusion
        for split_scores in scores_by_model.values()
    )
    split = SESSION if has_classes else RANDOM
    figures = [
        confusion_figure(model, split, scores)
        for model in names.estimators(scores_by_model)
        if (scores := scores_by_model[model].split(split)) and scores.confusion
    ]
    drawn = {
        model: subject.predictions[model, LEVEL]
        for model in names.estimators(ESTIMATORS)
        if (model, LEVEL) in subject.predictions
    }
    if drawn:
        figures.append(leave_one_out_figure(drawn))
    return figures


def confusion_figure(model: str, split: str, scores: SplitScores) -> Figure:
    counts = np.array(scores.confusion)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    ticks = [f"{c:g}" if isinstance(c, float) else str(c) for c in scores.classes or ()]
    with canvas(size=(6.2, 4.2)) as (figure, axes):
        ax = axes[0, 0]
        image_ = ax.imshow(share, cmap="Blues", vmin=0, vmax=1, aspect="auto")
        for (row, column), value in np.ndenumerate(share):
            if counts[row, column]:
                ax.text(
                    column,
                    row,
                    percent(value) if value < 1 else "100 %",
                    ha="center",
                    va="center",
                    fontsize=8.5,
                    color="white" if value > 0.55 else INK,
                )
        ax.set_xticks(range(len(ticks)), ticks)
        ax.set_yticks(range(len(ticks)), ticks)
        ax.set(xlabel="Predicted (Shore A)", ylabel="True (Shore A)")
        ax.grid(visible=False)
        ax.spines[:].set_visible(False)
        bar = figure.colorbar(image_, ax=ax, shrink=0.85)
        bar.set_label("Share of the true class")
        bar.ax.spines["outline"].set_visible(False)
        image = uri(figure)
    return Figure(
        f"confusion-{model}",
        f"Confusion, {names.estimator(model).title}, {names.SPLITS.get(split, split)}",
        f"{scores.n:,} pinches, each predicted by a model that was not trained on "
        + ("its session." if split == "by_session" else "it."),
        image,
    )


def leave_one_out_figure(drawn: Mapping[str, tuple[LabelledWindows, Values]]) -> Figure:
    appearances = {model: names.estimator(model) for model in drawn}
    levels = np.unique(next(iter(drawn.values()))[0].y)
    return box_figure(
        "levels",
        "A Shore A level left out",
        "Models of the other levels estimate each level. The softest and the stiffest lie outside "
        "of the training range.",
        "True Shore A, left out of training",
        {
            f"{level:g}": (
                float(level),
                {
                    appearances[model].title: predicted[data.y == level]
                    for model, (data, predicted) in drawn.items()
                },
            )
            for level in levels
        },
        {appearance.title: appearance.colour for appearance in appearances.values()},
    )


BLOCKS: Field[BlockResults] = Field("blocks", BlockResults, ByName({}, BlockConditions()))
#: Accuracy over the five blocks in the random split (section IV of the paper).
PUBLISHED = {"svm": 0.972, "cnn": 0.986}

_ACCURACY = Row[SplitScores]("accuracy", lambda s: bounded(s, "accuracy"), "share")
_RMSE = Row[SplitScores]("RMSE", lambda s: bounded(s, "rmse"), "shore")
_BIAS = Row[SplitScores]("Bias", lambda s: bounded(s, "bias"), "bias")
_CAPTIONS = {
    RANDOM: "Random 90/10, as published; sessions lie on both sides.",
    SESSION: "Whole sessions held out.",
    LEVEL: "One Shore A level left out of training.",
}


def steps_by_speed(
    title: str, measure: Callable[..., PartResult], cost: float, slow_cost: float
) -> list[Step]:
    """Return two steps that measure the installed estimators: the quick and the slow ones."""

    def run(is_slow: bool, subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
        kinds = window_estimators().items()
        able = [n for n, k in kinds if k.slow == is_slow and not missing_modules(k.modules)]
        return measure(subject, settings, runner, able)

    return [
        Step(title, partial(run, False), cost=cost),
        Step(f"{title}, slow estimators", partial(run, True), late=True, cost=slow_cost),
    ]


def block_table(
    results: SubjectResults, split: str, columns: Sequence[Row[SplitScores]]
) -> Table | None:
    entries = []
    for name in names.estimators(results[BLOCKS], True):
        scores, title = results[BLOCKS][name], names.estimator(name).title
        entries.append((Cell(title), scores.split(split), names.is_baseline(name)))
        if scores.strip_aligned:
            aligned = Cell(title, "window starts at the known contact")
            entries.append((aligned, scores.strip_aligned.split(split), False))
    caption = _CAPTIONS[split]
    if split == LEVEL and is_learned(results):
        caption += " The detector that places the windows was trained on that level too."
    return matrix(caption, columns, entries)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    rows = []
    scored = distinct(name for r in subjects.values() for name in r[BLOCKS])
    for name in names.estimators(distinct([*ESTIMATORS.names, *scored]), True):

        def split(
            split_name: str, name: str = name
        ) -> Callable[[SubjectResults], SplitScores | None]:
            return lambda results: results[BLOCKS].get(name, BlockScores()).split(split_name)

        prefix, published = f"Blocks, {names.estimator(name).title}, ", PUBLISHED.get(name)
        random, session = f"{prefix}random 90/10: ", f"{prefix}by session: "
        text = ABSENT if published is None else percent(published)
        claim = None if published is None else Claim(published, SHARE_TOLERANCE)
        rows += [
            row_for_results(_ACCURACY, random, split(RANDOM), text, claim=claim),
            row_for_results(_ACCURACY, session, split(SESSION)),
            row_for_results(_RMSE, session, split(SESSION)),
            row_for_results(_RMSE, f"{prefix}level left out: ", split(LEVEL)),
        ]
    return rows


PART = Part(
    "blocks",
    "Discrimination and regression",
    steps_by_speed("blocks", blocks, 30, 55),
    lambda subjects: (
        "One 15 ms window predicts which of the blocks was touched (discrimination), and its "
        "Shore A (regression). Pale lines are baselines."
    ),
    [
        lambda results: block_table(results, SESSION, (_ACCURACY, _RMSE)),
        lambda results: block_table(results, RANDOM, (_ACCURACY, _RMSE)),
        lambda results: block_table(results, LEVEL, (_RMSE, _BIAS)),
    ],
    _rows,
)
