"""Regression on objects that no model learned from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain
from math import sqrt

import numpy as np
from msgspec.structs import asdict, replace
from numpy.typing import NDArray

from firstcontact.core import INK, ByName, Dataset, Record, Runner, counted
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    Group,
    LabelledWindows,
    MeanErrors,
    Question,
    RegressionScores,
    SpecimenErrors,
    Split,
    Task,
    Values,
    bounded,
    held_out,
    learns_one_value,
    over_objects,
    per_object,
    regression_scores,
    unseen_objects,
)
from firstcontact.recording import figure_label
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Card, Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import boxes, canvas, uri
from firstcontact_lab.report.tables import (
    ABSENT,
    Cell,
    Line,
    Row,
    Table,
    lifted,
    matrix,
    number,
)
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.part import (
    Part,
    Step,
    Subjects,
    card_lines,
    distinct,
    per_subject,
)
from firstcontact_lab.study.parts.blocks import WindowCounts, able, published_or_all
from firstcontact_lab.study.settings import StudySettings


class ObjectScores(RegressionScores, frozen=True, kw_only=True):
    """An estimator on unseen objects: per pinch, per specimen, and of their means."""

    per_object: dict[str, SpecimenErrors]
    over_objects: MeanErrors
    strip_aligned: ObjectScores | None = None


class ObjectConditions(Record, frozen=True, kw_only=True):
    """Conditions of all estimators on objects; ``shares``: groups that both roles may share."""

    windows: WindowCounts | None = None
    shares: list[str] | None = None


ObjectResults = ByName[ObjectScores, ObjectConditions]


#: Under this name objects' predictions are kept for later parts.
UNSEEN = "unseen_objects"


def objects(
    subject: Subject, settings: StudySettings, runner: Runner, models: Sequence[str]
) -> PartResult:
    """Fit on all pinches of the role ``train`` and predict the role ``test``."""
    reason = why_not_unseen(subject)
    if reason:
        return PartResult(left_out=[reason])
    data = subject.windows(DURATION)
    splits = object_splits(subject, data)
    if not splits:
        return PartResult(
            left_out=[
                "Unseen objects: windows were found of no unseen object, or of fewer than two "
                "Shore A levels to learn from."
            ]
        )
    reference = ESTIMATORS.default
    questions = [
        Question(model, Task.REGRESSION, data, splits, settings.options(model)) for model in models
    ]
    is_predicted = [*models]
    aligned = subject.windows(DURATION, subject.truth)
    aligned_splits = object_splits(subject, aligned)
    if subject.detections and reference in models and aligned_splits:
        options = settings.options(reference)
        questions.append(Question(reference, Task.REGRESSION, aligned, aligned_splits, options))
        is_predicted.append("strip")
    answers = held_out(runner, questions, settings.seed)
    scores_by_model: dict[str, ObjectScores] = {}
    for name, question, predicted in zip(is_predicted, questions, answers, strict=True):
        scores = object_scores(question.data, predicted, settings.seed)
        if name == "strip":
            scores_by_model[reference] = replace(scores_by_model[reference], strip_aligned=scores)
            continue
        scores_by_model[name] = scores
        subject.predictions[name, UNSEEN] = (question.data, predicted)
    figures = [
        boxes_figure(name, *subject.predictions[name, UNSEEN]) for name in names.estimators(models)
    ]
    is_known = np.isfinite(subject.dataset.shore_a)
    shares = [str(s) for s in sorted(splits[0].shares)]
    about = ObjectConditions(
        windows=WindowCounts(
            pinches=int((subject.dataset.test & is_known).sum()), with_window=int(data.test.sum())
        ),
        shares=shares or None,
    )
    reasons = ["Unseen objects: sessions are not known and may be shared by both roles."]
    return PartResult([OBJECTS(ByName(scores_by_model, about))], figures, reasons if shares else [])


def object_splits(subject: Subject, data: LabelledWindows) -> list[Split]:
    """The one split of the roles, or none where it cannot be done with these windows."""
    if why_not_unseen(subject) or not data.test.any() or data.test.all():
        return []
    split = unseen_objects(data.test, [Group.SESSION] if _sessions_unknown(subject) else [])
    return [] if learns_one_value([split], data.y) else [split]


def object_scores(data: LabelledWindows, predicted: Values, seed: int) -> ObjectScores:
    """Scores per pinch (objects resampled whole) and per object."""
    is_predicted = np.isfinite(predicted)
    selected, answers = data.take(is_predicted), predicted[is_predicted]
    scores = regression_scores(selected.y, answers, specimen_names(selected), seed)
    each = per_object(selected.y, answers, specimen_names(selected), selected.objects)
    return ObjectScores(**asdict(scores), per_object=each, over_objects=over_objects(each))


def specimen_names(data: LabelledWindows) -> NDArray[np.str_]:
    """Specimen of each window, or its object where no specimen is named."""
    return np.where(data.specimens == "", data.objects, data.specimens)


def _sessions_unknown(subject: Subject) -> bool:
    return subject.dataset.sessions_assumed or "" in subject.dataset.sessions


def why_not_unseen(subject: Subject) -> str:
    """Return why a dataset has no unseen objects to score, "" if it has some."""
    dataset = subject.dataset
    if not (dataset.test & np.isfinite(dataset.shore_a)).any():
        return "Unseen objects: no pinch has the role `test` and a Shore A."
    if len(subject.levels) < 2:
        return "Unseen objects: fewer than two Shore A levels to learn from."
    specimens = _specimens(dataset.take(dataset.test)) & _specimens(dataset.take(~dataset.test))
    if specimens:
        kind, name = min(specimens)
        return (
            f"Unseen objects: the specimen {name!r} of {kind!r} has both roles, so it is not "
            "unseen."
        )
    sessions = set(dataset.sessions[dataset.test]) & set(dataset.sessions[~dataset.test]) - {""}
    if sessions and not subject.dataset.sessions_assumed:
        return f"Unseen objects: the session {str(min(sessions))!r} has pinches of both roles."
    return ""


def _specimens(dataset: Dataset) -> set[tuple[str, str]]:
    """Return object (or level without a name) and specimen of each pinch.

    Not the level beside the object: what is measured twice may differ, and is
    the same thing all the same.
    """
    labels = [pinch.label for pinch in dataset.pinches]
    return {
        (label.object or ("" if label.shore_a is None else f"{label.shore_a:g}"), label.specimen)
        for label in labels
    }


def boxes_figure(model: str, data: LabelledWindows, predicted: Values) -> Figure:
    """One box an object, with its true Shore A as a bar behind it."""
    is_predicted = np.isfinite(predicted)
    specimens = np.where(data.specimens == "", data.objects, data.specimens)[is_predicted]
    truth, answers = data.y[is_predicted], predicted[is_predicted]
    order = sorted(set(specimens.tolist()), key=lambda s: (float(truth[specimens == s].mean()), s))
    with canvas(size=(6.2, 4.0)) as (figure, axes):
        ax = axes[0, 0]
        true = [float(truth[specimens == s].mean()) for s in order]
        for i, value in enumerate(true):
            ax.plot(
                [i - 0.42, i + 0.42],
                [value, value],
                color=INK,
                lw=3,
                solid_capstyle="butt",
                label="true value" if i == 0 else None,
                zorder=2,
            )
        groups = [answers[specimens == s] for s in order]
        boxes(ax, groups, range(len(order)), 0.55, names.estimator(model).colour)
        written = [figure_label(s.replace("_", " ")) for s in order]
        labels = [f"{name}\n({v:g})" for name, v in zip(written, true, strict=True)]
        ax.set_xticks(range(len(order)), labels, fontsize=8)
        if len(order) > 8 or max(map(len, written)) > 10:
            ax.tick_params(axis="x", rotation=35)
        ax.set(ylabel="Estimated Shore A", xlabel="Object (true Shore A)")
        if min(answers.min(), truth.min()) >= 0 and max(answers.max(), truth.max()) <= 80:
            ax.set_ylim(0, 80)  # the same for all models and conditions
        ax.grid(axis="x", visible=False)
        ax.legend(loc="upper left")
        image = uri(figure)
    return Figure(
        f"boxes-{model}",
        f"Unseen objects, {names.estimator(model).title}",
        "Estimates for each object (box: middle half, whiskers: 1.5 times that) by a model that "
        "has never seen it; thick bars are the true values.",
        image,
    )


OBJECTS: Field[ObjectResults] = Field("objects", ObjectResults, ByName({}, ObjectConditions()))
#: "MSE" over the eight objects, given in Shore A (section IV of the paper).
PUBLISHED = {"svm": 4.17, "cnn": 2.39}

_RMSE = Row[ObjectScores]("RMSE", lambda s: bounded(s, "rmse"), "shore")
_MAE = Row[ObjectScores]("MAE", lambda s: bounded(s, "mae"), "shore")
_MSE = Row[ObjectScores]("MSE", lambda s: bounded(s, "mse"), "square")
_SCORES = (
    _RMSE,
    _MAE,
    _MSE,
    Row[ObjectScores]("Bias", lambda s: bounded(s, "bias"), "bias"),
    Row[ObjectScores]("RMSE of means", lambda s: s.over_objects.rmse, "shore"),
)


def _text(subjects: Subjects) -> str:
    scores = [s for results in subjects.values() for s in results[OBJECTS].values()]
    counts = distinct(str(s.over_objects.n) for s in scores)
    many = f" ({' and '.join(counts)} here)" if counts else ""
    return (
        "No model has learned from these objects. Small numbers are 95 % bootstrap intervals over "
        f"whole objects{many}."
    )


def object_table(results: SubjectResults) -> Table | None:
    """Return the scores of all estimators on unseen objects."""
    entries: list[tuple[Cell, ObjectScores | None, bool]] = []
    for name in names.estimators(results[OBJECTS], True):
        scores, title = results[OBJECTS][name], names.estimator(name).title
        aligned = Cell(title, "window starts at the known contact")
        entries.append((Cell(title), scores, names.is_floor(name)))
        entries.append((aligned, scores.strip_aligned, False))
    return matrix("Objects that no model learned from; Shore A.", _SCORES, entries)


def per_object_table(results: SubjectResults) -> Table | None:
    """Return mean, spread and bias for each object and estimator without the floors."""
    each = {n: results[OBJECTS][n].per_object for n in names.estimators(results[OBJECTS])}
    if not each:
        return None
    first = next(iter(each.values()))
    lines = []
    for name in sorted(first, key=lambda name: (first[name].true, name)):
        object_errors = first[name]
        cells = [
            Cell(name.replace("_", " "), counted(object_errors.n, "pinch")),
            Cell(f"{object_errors.true:g}"),
        ]
        for errors in (scores.get(name) for scores in each.values()):
            if errors is None:
                cells += [Cell(ABSENT), Cell(ABSENT)]
                continue
            spread = "" if errors.sd is None else f" ± {errors.sd:.1f}"
            cells.append(Cell(f"{errors.mean:.1f}{spread}", f"RMSE {errors.rmse:.2f}"))
            cells.append(Cell(number(errors.bias, 1, "+")))
        lines.append(Line(cells))
    heads = [(f"{names.estimator(n).title}, mean ± SD", "bias") for n in each]
    return Table("Each object by itself; Shore A.", ["", "True", *chain(*heads)], lines)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    rows = []
    scored = distinct(name for r in subjects.values() for name in r[OBJECTS])
    for name in names.estimators(distinct([*ESTIMATORS.names, *scored]), True):

        def find(results: SubjectResults, name: str = name) -> ObjectScores | None:
            return results[OBJECTS].get(name)

        prefix, published = f"Unseen objects, {names.estimator(name).title}: ", PUBLISHED.get(name)
        if published is None:
            rows += [lifted(row, prefix, find) for row in (_RMSE, _MAE, _MSE)]
            continue
        remark, headline = _error_remark(name, subjects, published), name == ESTIMATORS.default
        rows += [
            lifted(_RMSE, prefix, find, remark=remark, headline=headline),
            lifted(_MAE, prefix, find, remark="Shore A. Not published."),
            lifted(_MSE, prefix, find, f"{published} “MSE”", _MSE_REMARK),
        ]
    return rows


_MSE_REMARK = (
    "Shore A squared. The paper calls its number an MSE but gives it in Shore A: compare with both "
    "the RMSE and the MSE."
)


def _error_remark(name: str, subjects: Subjects, value: float) -> str:
    root = sqrt(value)

    def verdict(results: SubjectResults) -> str | None:
        scores = results[OBJECTS].get(name)
        if scores is None:
            return None
        above, below = scores.rmse > value, scores.rmse < root
        return "above both" if above else "below both" if below else "between"

    verdicts = per_subject(subjects, verdict)
    if not verdicts:
        return "Shore A."
    return (
        f"Shore A. The published {value} would be an RMSE of {root:.2f} if it is an MSE, of "
        f"{value} if it is one already; {'; '.join(verdicts)}."
    )


def _cards(subjects: Subjects) -> list[Card]:
    scores = [results[OBJECTS] for results in subjects.values()]
    floors = distinct(f"{s['train_mean'].rmse:.2f}" for s in scores if "train_mean" in s)
    floor = f"; predicting the mean always gives {' and '.join(floors)}" if floors else ""

    def scores_of(name: str) -> Callable[[SubjectResults], ObjectScores | None]:
        return lambda results: results[OBJECTS].get(name)

    rows = {
        names.estimator(name).title: lifted(_RMSE, "", scores_of(name))
        for name in published_or_all(PUBLISHED, scores)
    }
    return [Card("Unseen objects: RMSE", card_lines(subjects, rows), f"Shore A, one pinch{floor}")]


PART = Part(
    "objects",
    "Unseen objects",
    [
        Step("objects", lambda s, settings, runner: objects(s, settings, runner, able(slow=False))),
        Step(
            "objects, slow estimators",
            lambda s, settings, runner: objects(s, settings, runner, able(slow=True)),
            late=True,
        ),
    ],
    _text,
    [object_table, per_object_table],
    _rows,
    _cards,
)
