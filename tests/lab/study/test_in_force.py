"""Estimates in force: measured delays decide which estimate is the last one in time."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from excerpts import subject, twin_pinches

from firstcontact.core import InputError, Serial
from firstcontact.twin import BLOCKS, EVERYDAY_OBJECTS
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.anytime import ANYTIME, AnytimeResults, anytime
from firstcontact_lab.study.parts.in_force import IN_FORCE, Delays, InForce, in_force, read_delays
from firstcontact_lab.study.settings import StudySettings

BRIEF = StudySettings().quick()


@pytest.fixture(scope="module")
def conditioned() -> tuple[Subject, AnytimeResults]:
    pinches = twin_pinches(BLOCKS, 6, 3) + twin_pinches(EVERYDAY_OBJECTS[:3], 4, 2)
    made = subject(pinches)
    results = anytime(made, BRIEF, Serial()).results[ANYTIME]
    assert results is not None
    return made, results


def scores(made: Subject, folder: Path, *delays_ms: float) -> InForce | None:
    path = folder / "live.json"
    path.write_text(json.dumps({"machine": "a computer", "delays_ms": delays_ms}))
    return in_force(made, replace(BRIEF, delays=str(path))).results[IN_FORCE]


def test_without_delay_every_estimate_with_enough_signal_is_in_force(
    conditioned: tuple[Subject, AnytimeResults], tmp_path: Path
) -> None:
    made, by_time = conditioned
    at_once = scores(made, tmp_path, 0.0, 0.0)
    assert at_once is not None
    assert (at_once.share, at_once.with_second) == (by_time.before_second, by_time.with_second)
    assert 0 < at_once.rmse < 40
    offsets = [1e3 * p.offset for p in made.dataset.take(made.dataset.test) if p.offset]
    assert at_once.n == len(offsets)
    assert at_once.signal_ms <= np.median(np.minimum(offsets, 15)) + 0.5


def test_longer_delays_leave_fewer_estimates_with_less_signal(
    conditioned: tuple[Subject, AnytimeResults], tmp_path: Path
) -> None:
    made = conditioned[0]
    quick, slow = (scores(made, tmp_path, ms, ms) for ms in (1.0, 8.0))
    assert quick is not None
    assert slow is not None
    assert slow.share < quick.share
    assert slow.n < quick.n
    assert slow.signal_ms < quick.signal_ms
    assert scores(made, tmp_path, 500.0, 500.0) is None


def test_without_delays_or_a_model_nothing_is_scored(
    conditioned: tuple[Subject, AnytimeResults], tmp_path: Path
) -> None:
    made = conditioned[0]
    outcome = in_force(made, BRIEF)
    assert outcome.results[IN_FORCE] is None
    assert not outcome.left_out
    path = tmp_path / "live.json"
    path.write_text('{"machine": "a computer", "delays_ms": [0, 1]}')
    outcome = in_force(Subject("any", made.dataset), replace(BRIEF, delays=str(path)))
    assert outcome.left_out


def test_drawn_delays_follow_the_quantiles() -> None:
    delays = Delays("a computer", (1.0, 2.0, 10.0))
    drawn = delays.draw(20_000, np.random.default_rng(0))
    assert drawn.min() >= 1e-3
    assert drawn.max() <= 10e-3
    assert np.mean(drawn < 2e-3) == pytest.approx(0.5, abs=0.02)
    assert delays.quantile(0.5) == 2.0


@pytest.mark.parametrize(
    "text",
    ["", "[1, 2]", '{"machine": "m", "delays_ms": [1]}', '{"machine": "m", "delays_ms": [2, 1]}'],
)
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "live.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"live\.json"):
        read_delays(path)
