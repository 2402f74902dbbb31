"""Regression on objects that no model has seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from msgspec.structs import asdict, replace
from numpy.typing import NDArray

from firstcontact.core import ByName, Dataset, Runner
from firstcontact.models import (
    DURATION,
    ESTIMATORS,
    Group,
    LabelledWindows,
    Question,
    Split,
    Task,
    Values,
    held_out,
    learns_one_value,
    over_objects,
    per_object,
    regression_scores,
    unseen_objects,
)
from firstcontact_lab.report import names
from firstcontact_lab.report.figures.boxes import boxes_figure
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results.stiffness import ObjectConditions, ObjectScores, WindowCounts
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

#: Under this name objects' predictions are kept for later parts.
UNSEEN = "unseen_objects"


def objects(
    subject: Subject, settings: StudySettings, runner: Runner, models: Sequence[str]
) -> PartResult:
    """Learn from all pinches of the role ``train``, ask about those of ``test``."""
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
    asked = [*models]
    aligned = subject.windows(DURATION, subject.truth)
    aligned_splits = object_splits(subject, aligned)
    if subject.found and reference in models and aligned_splits:
        options = settings.options(reference)
        questions.append(Question(reference, Task.REGRESSION, aligned, aligned_splits, options))
        asked.append("strip")
    answers = held_out(runner, questions, settings.seed)
    found: dict[str, ObjectScores] = {}
    for name, question, predicted in zip(asked, questions, answers, strict=True):
        scores = object_scores(question.data, predicted, settings.seed)
        if name == "strip":
            found[reference] = replace(found[reference], strip_aligned=scores)
            continue
        found[name] = scores
        subject.predictions[name, UNSEEN] = (question.data, predicted)
    figures = [
        boxes_figure(name, *subject.predictions[name, UNSEEN]) for name in names.estimators(models)
    ]
    known = np.isfinite(subject.dataset.shore_a)
    shares = [str(s) for s in sorted(splits[0].shares)]
    about = ObjectConditions(
        windows=WindowCounts(
            pinches=int((subject.dataset.test & known).sum()), with_window=int(data.test.sum())
        ),
        shares=shares or None,
    )
    said = ["Unseen objects: sessions are not known and may be shared by both roles."]
    return PartResult(SubjectResults(objects=ByName(found, about)), figures, said if shares else [])


def object_splits(subject: Subject, data: LabelledWindows) -> list[Split]:
    """The one split of the roles, or none where it cannot be done with these windows."""
    if why_not_unseen(subject) or not data.test.any() or data.test.all():
        return []
    split = unseen_objects(data.test, [Group.SESSION] if _sessions_unknown(subject) else [])
    return [] if learns_one_value([split], data.y) else [split]


def object_scores(data: LabelledWindows, predicted: Values, seed: int) -> ObjectScores:
    """Scores per pinch (objects resampled whole) and per object."""
    asked = np.isfinite(predicted)
    its, answers = data.take(asked), predicted[asked]
    scores = regression_scores(its.y, answers, things(its), seed)
    each = per_object(its.y, answers, things(its), its.objects)
    return ObjectScores(**asdict(scores), per_object=each, over_objects=over_objects(each))


def things(data: LabelledWindows) -> NDArray[np.str_]:
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
    """Object, or level where none is named, and specimen.

    Not the level beside the object: what is measured twice may differ, and is
    the same thing all the same.
    """
    labels = [pinch.label for pinch in dataset.pinches]
    return {
        (label.object or ("" if label.shore_a is None else f"{label.shore_a:g}"), label.specimen)
        for label in labels
    }
