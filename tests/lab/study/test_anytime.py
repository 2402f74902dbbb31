"""Estimates at any time: the scored pinches, the counts and the times."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.core import Contact, Dataset, Label, Pinch, Role
from firstcontact.core._pinch import Finger
from firstcontact.models import lengths
from firstcontact.twin import (
    BLOCKS,
    EVERYDAY_OBJECTS,
    PAPER_RIG,
    draw_pinch,
    excerpt,
    simulate_pinch,
)
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.anytime import ANYTIME, AnytimeResults, anytime, anytime_table
from firstcontact_lab.study.settings import StudySettings

BRIEF = StudySettings().quick()
RATE = 4936.0


def twin_pinches(kinds, each: int, sessions: int) -> list[Pinch]:
    out = []
    for kind in kinds:
        for number in range(each):
            session = f"{kind.role} {number % sessions}"
            label = Label(kind.name, kind.shore_a, None, kind.name, session, kind.role)
            draw = draw_pinch(7, PAPER_RIG, session, kind, f"{kind.name} {number}")
            out.append(simulate_pinch(excerpt(draw, 0.045), label, duration=0.07))
    return out


@pytest.fixture(scope="module")
def blocks() -> list[Pinch]:
    return twin_pinches(BLOCKS, 6, 3)


@pytest.fixture(scope="module")
def objects() -> list[Pinch]:
    return twin_pinches(EVERYDAY_OBJECTS[:3], 4, 2)


def score(pinches: list[Pinch], late: int = 2, decided: int = 8) -> AnytimeResults | None:
    contacts = tuple(
        p.first and Contact(p.first.finger, p.first.sample + late, p.first.sample + decided)
        for p in pinches
    )
    outcome = anytime(Subject("any", Dataset(tuple(pinches)), contacts), BRIEF)
    assert (outcome.results[ANYTIME] is None) == bool(outcome.left_out)
    return outcome.results[ANYTIME]


def test_unseen_objects_are_asked_about_and_blocks_of_other_sessions(blocks, objects) -> None:
    scores = score(blocks + objects)
    assert (scores.asked, scores.fixed) == ("objects", None)
    assert scores.n + scores.too_short == len(objects)
    assert scores.blocks.n <= len(blocks)
    for entry in (scores, scores.blocks):
        assert list(entry.rmse) == ["2", "3", "5", "8", "15"]
        assert all(0 <= share <= 1 for share in entry.coverage.values())
        assert all(0 < width <= 100 for width in entry.width.values())
        assert all(
            low <= entry.rmse[ms] <= high for ms, (low, high) in entry.intervals["rmse"].items()
        )


def test_without_unseen_objects_blocks_stand_first(blocks) -> None:
    scores = score(blocks)
    assert (scores.asked, scores.blocks) == ("blocks", None)


def test_unknown_quantities_are_stated(blocks, objects) -> None:
    assert score(objects) is None
    assert score(blocks[:6]) is None


def test_an_answer_waits_for_the_decision_and_for_its_samples(blocks, objects) -> None:
    pinches = blocks + objects
    offsets = np.array([p.offset for p in pinches if p.offset is not None])
    shortest = lengths(RATE)[0]
    at_once, later = score(pinches, 0, 0), score(pinches, 0, 40)
    assert at_once.with_second == later.with_second == len(offsets)
    assert at_once.before_second == np.mean(offsets > (shortest - 1) / RATE)
    assert later.before_second == np.mean(offsets > 40 / RATE)


def test_another_finger_is_no_answer(blocks, objects) -> None:
    pinches = blocks + objects
    other = {Finger.THUMB: Finger.INDEX, Finger.INDEX: Finger.THUMB}
    contacts = tuple(
        Contact(other[p.first.finger], p.first.sample, p.first.sample) for p in pinches
    )
    scores = anytime(Subject("any", Dataset(tuple(pinches)), contacts), BRIEF).results[ANYTIME]
    assert scores is None or scores.before_second == 0.0


def test_no_sample_after_the_second_contact_is_used(blocks, objects) -> None:
    def noisy(pinch: Pinch) -> Pinch:
        if pinch.second is None:
            return pinch
        data = pinch.data.copy()
        data[pinch.second.sample - pinch.first_sample :] = 30_000
        return Pinch(data, pinch.layout, pinch.label, pinch.first_sample, pinch.truth)

    assert score(blocks + objects) == score([noisy(p) for p in blocks + objects])


def test_the_table_has_a_column_a_time(blocks, objects) -> None:
    pinches = Dataset(tuple(blocks + objects))
    results = anytime(Subject("any", pinches), BRIEF).results
    table = anytime_table(results)
    assert results.anytime.before_second is None  # contacts were not found but known
    assert all(len(row.cells) == len(table.head) == 6 for row in table.lines)
    assert all(p.label.role is Role.TEST for p in objects)
