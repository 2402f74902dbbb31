"""Windows with the second contact, and the force of the first finger before it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from excerpts import twin_pinches

from firstcontact.core import ChannelKind, Contact, Dataset, Pinch
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.data import EARLY_FORCE, describe, early_force
from firstcontact_lab.study.parts.objects import UNSEEN
from firstcontact_lab.study.parts.second_contact import (
    SECOND_CONTACT,
    misplaced,
    second_contact,
    second_table,
)

MS = 4.936


def subject(dataset: Dataset, shifts: dict[int, Contact]) -> Subject:
    """Return a subject whose windows start at the true contacts, moved by these shifts."""
    made = Subject("a", dataset)
    made.detections = tuple(shifts.get(i, p.first) for i, p in enumerate(dataset.pinches))
    return made


def moved(contact: Contact, ms: float) -> Contact:
    return replace(contact, sample=contact.sample + round(ms * MS))


def test_windows_of_false_triggers_have_a_separate_row(make_shore: Callable[..., Dataset]) -> None:
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


@pytest.fixture(scope="module")
def pinch() -> Pinch:
    return next(p for p in twin_pinches(EVERYDAY_OBJECTS[:1], 4, 1) if p.second is not None)


def stepped(pinch: Pinch, before: float, after: float) -> Pinch:
    """Return the pinch with a constant force before and after the second contact."""
    first, second = (contact.sample - pinch.first_sample for contact in pinch.truth[:2])
    data = pinch.data.copy()
    for finger in {contact.finger for contact in pinch.truth}:
        columns = list(pinch.layout.columns(ChannelKind.FORCE, finger))
        data[:first, columns], data[first:second, columns], data[second:, columns] = (
            0,
            before,
            after,
        )
    return replace(pinch, data=data)


def test_the_force_is_a_share_of_the_later_force(pinch: Pinch) -> None:
    for before in (0, 100, 250):
        assert early_force(stepped(pinch, before, 1000)) == pytest.approx(before / 1000)
    assert early_force(stepped(pinch, 0, 0)) is None
    assert early_force(replace(pinch, truth=pinch.truth[:1])) is None


def test_the_data_have_the_median_over_pinches(pinch: Pinch) -> None:
    pinches = tuple(stepped(pinch, before, 1000) for before in (0, 100, 900))
    force = describe(Subject("any", Dataset(pinches))).results[EARLY_FORCE]
    assert force is not None
    assert (force.n, force.median) == (3, pytest.approx(0.1))
    assert force.median <= force.p95 <= 0.9
