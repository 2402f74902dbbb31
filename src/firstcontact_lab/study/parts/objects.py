"""Study part ``objects``: errors on objects on which no estimator was trained."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from msgspec.structs import asdict, replace
from numpy.typing import NDArray

from firstcontact.core import Dataset, Record
from firstcontact.core.records import ByName
from firstcontact.jobs import Runner
from firstcontact.models import ESTIMATORS, Task
from firstcontact.models.labelled_data import DURATION, LabelledWindows
from firstcontact.models.scores import (
    RegressionScores,
    SpecimenErrors,
    per_object,
    regression_scores,
)
from firstcontact.models.splits import Group, Split
from firstcontact.models.training import Question, held_out
from firstcontact.models.values import Values
from firstcontact.plots.style import figure_label
from firstcontact_lab.report import names
from firstcontact_lab.report.findings import Figure, PartResult, missing
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.style import box_figure
from firstcontact_lab.report.tables import (
    ERROR_TOLERANCE,
    Cell,
    Claim,
    Row,
    Table,
    bounded,
    matrix,
    row_for_results,
)
from firstcontact_lab.study.part import Part, StudySettings, Subject, Subjects, distinct
from firstcontact_lab.study.parts.blocks import WindowCounts, steps_by_speed
from firstcontact_lab.study.scores import MeanErrors, learns_one_value, over_objects, unseen_objects


class ObjectScores(RegressionScores, frozen=True, kw_only=True):
    per_object: dict[str, SpecimenErrors]
    over_objects: MeanErrors
    strip_aligned: ObjectScores | None = None


class ObjectConditions(Record, frozen=True, kw_only=True):
    windows: WindowCounts | None = None
    shares: list[str] | None = None


ObjectResults = ByName[ObjectScores, ObjectConditions]


#: Key of the predictions for objects, which later parts use.
UNSEEN = "unseen_objects"


def measure_objects(
    subject: Subject, settings: StudySettings, runner: Runner, models: Sequence[str]
) -> PartResult:
    reason = why_not_unseen(subject)
    if reason:
        return missing(reason)
    data = subject.windows(DURATION)
    splits = object_splits(subject, data)
    if not splits:
        return missing(
            "Unseen objects: no unseen object has a window, or the training pinches with a "
            "window have fewer than two Shore A levels."
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
    is_known = np.isfinite(subject.dataset.shore_a)
    shares = [str(s) for s in sorted(splits[0].shares)]
    about = ObjectConditions(
        windows=WindowCounts(
            pinches=int((subject.dataset.test & is_known).sum()), with_window=int(data.test.sum())
        ),
        shares=shares or None,
    )
    reasons = ["Unseen objects: sessions are not known and may be shared by both roles."]
    drawn = {
        model: subject.predictions[model, UNSEEN]
        for model in PUBLISHED
        if (model, UNSEEN) in subject.predictions
    }
    return PartResult(
        [OBJECTS(ByName(scores_by_model, about))],
        [objects_figure(drawn)] if drawn else [],
        reasons if shares else [],
    )


def object_splits(subject: Subject, data: LabelledWindows) -> list[Split]:
    """Return a list with the split into training pinches and unseen objects.

    The list is empty if the dataset does not permit this split.
    """
    if why_not_unseen(subject) or not data.test.any() or data.test.all():
        return []
    split = unseen_objects(data.test, [Group.SESSION] if _sessions_unknown(subject) else [])
    return [] if learns_one_value([split], data.y) else [split]


def object_scores(data: LabelledWindows, predicted: Values, seed: int) -> ObjectScores:
    """Return the errors on all pinches and by object.

    Bootstrap intervals draw whole specimens.
    """
    is_predicted = np.isfinite(predicted)
    selected, answers = data.take(is_predicted), predicted[is_predicted]
    scores = regression_scores(selected.y, answers, specimen_names(selected), seed)
    each = per_object(selected.y, answers, specimen_names(selected), selected.objects)
    return ObjectScores(**asdict(scores), per_object=each, over_objects=over_objects(each))


def specimen_names(data: LabelledWindows) -> NDArray[np.str_]:
    """Return the specimen of each window. An unnamed specimen gets the name of its object."""
    return np.where(data.specimens == "", data.objects, data.specimens)


def _sessions_unknown(subject: Subject) -> bool:
    return subject.dataset.sessions_assumed or "" in subject.dataset.sessions


def why_not_unseen(subject: Subject) -> str:
    """Return the reason why a dataset has no unseen objects to score, or "" if it has some."""
    dataset = subject.dataset
    if not (dataset.test & np.isfinite(dataset.shore_a)).any():
        return "Unseen objects: no pinch has the role `test` and a Shore A."
    if len(subject.levels) < 2:
        return "Unseen objects: the training pinches have fewer than two Shore A levels."
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
    """Return all pairs (object, specimen). An unnamed object is identified by its Shore A."""
    labels = [pinch.label for pinch in dataset.pinches]
    return {
        (label.object or ("" if label.shore_a is None else f"{label.shore_a:g}"), label.specimen)
        for label in labels
    }


OBJECTS: Field[ObjectResults] = Field("objects", ObjectResults, ByName({}, ObjectConditions()))
#: "MSE" over the eight objects, given in Shore A (section IV of the paper).
PUBLISHED = {"svm": 4.17, "cnn": 2.39}

_RMSE = Row[ObjectScores]("RMSE", lambda s: bounded(s, "rmse"), "shore")
_MAE = Row[ObjectScores]("MAE", lambda s: bounded(s, "mae"), "shore")
_MSE = Row[ObjectScores]("MSE", lambda s: bounded(s, "mse"), "square")
_BIAS = Row[ObjectScores]("Bias", lambda s: bounded(s, "bias"), "bias")


def objects_figure(drawn: Mapping[str, tuple[LabelledWindows, Values]]) -> Figure:
    appearances = {model: names.estimator(model) for model in drawn}
    boxed: dict[str, tuple[float, dict[str, Values]]] = {}
    for model, (data, predicted) in drawn.items():
        specimens = specimen_names(data)
        for specimen in np.unique(specimens):
            chosen = (specimens == specimen) & np.isfinite(predicted)
            if chosen.any():
                name = figure_label(str(specimen).replace("_", " "))
                truth = float(data.y[chosen].mean())
                entry = boxed.setdefault(name, (truth, {}))
                entry[1][appearances[model].title] = predicted[chosen]
    return box_figure(
        "objects",
        "Estimates of each unseen object",
        "Boxes hold the middle half of an object's pinches. No model was trained on these objects.",
        "",
        dict(sorted(boxed.items(), key=lambda item: item[1][0])),
        {appearance.title: appearance.colour for appearance in appearances.values()},
    )


def object_table(results: SubjectResults) -> Table | None:
    entries: list[tuple[Cell, ObjectScores | None, bool]] = []
    for name in names.estimators(results[OBJECTS], True):
        scores, title = results[OBJECTS][name], names.estimator(name).title
        aligned = Cell(title, "window starts at the known contact")
        entries.append((Cell(title), scores, names.is_baseline(name)))
        entries.append((aligned, scores.strip_aligned, False))
    return matrix("Shore A.", (_RMSE, _BIAS), entries)


def _rows(subjects: Subjects) -> list[Row[SubjectResults]]:
    rows = []
    scored = distinct(name for r in subjects.values() for name in r[OBJECTS])
    for name in names.estimators(distinct([*ESTIMATORS.names, *scored]), True):

        def find(results: SubjectResults, name: str = name) -> ObjectScores | None:
            return results[OBJECTS].get(name)

        prefix, published = f"Unseen objects, {names.estimator(name).title}: ", PUBLISHED.get(name)
        if published is None:
            rows += [row_for_results(row, prefix, find) for row in (_RMSE, _MAE, _MSE)]
            continue
        claim = Claim(published, ERROR_TOLERANCE * published, lower=True)
        headline, text = name == ESTIMATORS.default, f"{published} “MSE”"
        rows += [
            row_for_results(_RMSE, prefix, find, text, headline, claim),
            row_for_results(_MAE, prefix, find),
            row_for_results(_MSE, prefix, find, text),
        ]
    return rows


PART = Part(
    "objects",
    "Unseen objects",
    steps_by_speed("objects", measure_objects, 5, 6),
    tables=[object_table],
    rows=_rows,
)
