"""Scores of windows with and without the second contact.

Only windows that begin at the first contact count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from firstcontact.core import Contact, Dataset
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.objects import UNSEEN
from firstcontact_lab.study.parts.second_contact import (
    SECOND_CONTACT,
    misplaced,
    second_contact,
    second_table,
)
from firstcontact_lab.study.settings import StudySettings

MS = 4.936


def subject(dataset: Dataset, shifts: dict[int, Contact]) -> Subject:
    """Return a subject whose windows start at the true contacts, moved by these shifts."""
    made = Subject("a", dataset)
    made.detections = tuple(shifts.get(i, p.first) for i, p in enumerate(dataset.pinches))
    return made


def moved(contact: Contact, ms: float) -> Contact:
    return replace(contact, sample=contact.sample + round(ms * MS))


def test_windows_of_false_triggers_have_a_separate_row(
    make_shore: Callable[..., Dataset],
) -> None:
    dataset = make_shore(each=10, objects=(20.0, 50.0))
    held_out = np.flatnonzero(dataset.test)
    first = {int(i): dataset.pinches[i].first for i in held_out}
    early, late, other, fair = held_out[:4]
    astray = {
        int(early): moved(first[early], -40.0),
        int(late): moved(first[late], 4.0),
        int(other): replace(first[other], finger=first[other].finger.other),
        int(fair): moved(first[fair], -2.0),
    }
    study_subject = subject(dataset, astray)
    assert np.flatnonzero(misplaced(study_subject, 0.0)).tolist() == sorted([early, late, other])
    data = study_subject.windows(0.015)
    predicted = np.where(misplaced(study_subject, 0.0)[data.rows], data.y + 50.0, data.y + 1.0)
    predicted[~data.test] = np.nan
    study_subject.predictions["svm", UNSEEN] = (data, predicted)
    outcome = second_contact(study_subject, StudySettings())
    results = outcome.results[SECOND_CONTACT]
    assert results is not None
    sides = results["svm"].objects
    assert sides is not None
    assert sides["misplaced"].n == 3
    assert sides["misplaced"].rmse == 50.0
    assert sides["without"].rmse == 1.0
    assert sum(side.n for side in sides.values()) == int(data.test.sum())
    table = second_table(outcome.results)
    assert table is not None
    assert any("misplaced" in row.cells[0].text for row in table.lines)


def test_late_labels_let_windows_begin_earlier(make_shore: Callable[..., Dataset]) -> None:
    dataset = make_shore(each=4, objects=())
    study_subject = subject(dataset, {0: moved(dataset.pinches[0].first, -6.0)})
    assert misplaced(study_subject, 0.0)[0]
    assert not misplaced(study_subject, 0.004)[0]
