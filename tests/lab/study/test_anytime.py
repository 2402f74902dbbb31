"""Estimates at any time: which pinches are scored, the counts, and the times."""

from pathlib import Path

import numpy as np
import pytest
from excerpts import subject, twin_pinches
from msgspec.structs import replace

from firstcontact.core import Pinch
from firstcontact.jobs import Serial
from firstcontact.models import ESTIMATORS, Touches
from firstcontact.twin import BLOCKS
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.study.part import StudySettings
from firstcontact_lab.study.parts.anytime import (
    ANYTIME,
    AnytimeResults,
    anytime,
    known_before_second,
)

BRIEF = StudySettings().quick()
RATE = 4936.0


@pytest.fixture(scope="module")
def blocks() -> list[Pinch]:
    return twin_pinches(BLOCKS, 6, 3)


@pytest.fixture(scope="module")
def objects() -> list[Pinch]:
    return twin_pinches(EVERYDAY_OBJECTS[:3], 4, 2)


def score(pinches: list[Pinch]) -> AnytimeResults | None:
    outcome = anytime(subject(pinches), BRIEF, Serial())
    assert (outcome.results[ANYTIME] is None) == bool(outcome.left_out)
    return outcome.results[ANYTIME]


@pytest.fixture(scope="module")
def outcome(blocks, objects) -> PartResult:
    return anytime(subject(blocks + objects), BRIEF, Serial())


def test_unseen_objects_are_asked_about_and_blocks_of_other_sessions(
    outcome, blocks, objects
) -> None:
    scores = outcome.results[ANYTIME]
    assert not outcome.left_out
    assert (scores.pinches, scores.fixed) == ("objects", None)
    assert scores.n + scores.too_short == len(objects)
    assert scores.blocks.n <= len(blocks)
    for entry in (scores, scores.blocks):
        assert list(entry.rmse) == ["2", "3", "5", "8", "15"]
        assert all(0 <= share <= 1 for share in entry.coverage.values())
        assert all(0 < width <= 100 for width in entry.width.values())
        assert all(
            low <= entry.rmse[ms] <= high
            for ms, (low, high) in entry.intervals.get("rmse", {}).items()
        )
    share = known_before_second(subject(blocks + objects), BRIEF.early)
    assert (scores.before_second, scores.with_second) == share


def test_without_unseen_objects_blocks_stand_first(blocks) -> None:
    scores = score(blocks)
    assert (scores.pinches, scores.blocks) == ("blocks", None)


def test_unknown_quantities_are_stated(blocks, objects) -> None:
    assert score(objects) is None
    assert score(blocks[:6]) is None


def test_an_answer_waits_for_the_decision_and_for_its_samples(blocks, objects) -> None:
    pinches = blocks + objects
    offsets = np.array([p.offset for p in pinches if p.offset is not None])
    shortest = Touches.lengths(RATE)[0]
    for decided, wait in ((0, (shortest - 1) / RATE), (40, 40 / RATE)):
        share, of = known_before_second(subject(pinches, 0, decided), BRIEF.early)
        assert (share, of) == (np.mean(offsets > wait), len(offsets))


def test_no_sample_after_the_second_contact_is_used(outcome, blocks, objects) -> None:
    def noisy(pinch: Pinch) -> Pinch:
        if pinch.second is None:
            return pinch
        data = pinch.data.copy()
        data[pinch.second.sample - pinch.first_sample :] = 30_000
        return Pinch(data, pinch.layout, pinch.label, pinch.first_sample, pinch.truth)

    assert outcome.results[ANYTIME] == score([noisy(p) for p in blocks + objects])


REGRESSOR = """
import numpy as np

class Sealed:
    # Refuses windows that it has learned from.
    def fit(self, X, y):
        self.line = np.polyfit(np.log(X.std(axis=1)), y, 1)
        self.learned = {row.tobytes() for row in X}

    def predict(self, X):
        if any(row.tobytes() in self.learned for row in X):
            raise RuntimeError("these windows are not held out")
        return np.polyval(self.line, np.log(X.std(axis=1)))
"""


def test_a_regressor_of_the_user_is_scored_on_the_same_held_out_pinches(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, outcome, blocks, objects
) -> None:
    (tmp_path / "their_regressors.py").write_text(REGRESSOR, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    try:
        ESTIMATORS.include("their_regressors:Sealed")
        scores = score(blocks + objects)
    finally:
        ESTIMATORS.reload()
    theirs = scores.other_estimators["their_regressors:Sealed"]
    usual = outcome.results[ANYTIME]
    assert replace(scores, other_estimators=usual.other_estimators) == usual
    for entry, same in ((theirs.unseen, usual), (theirs.blocks, usual.blocks)):
        assert (entry.n, list(entry.rmse)) == (same.n, list(same.rmse))
