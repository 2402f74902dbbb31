"""Part ``closing_speed``: what the network gains from measured closing speeds."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.core import Dataset, Serial
from firstcontact.twin import (
    CONDITIONS,
)
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study._random_rigs import FREE_SPEED, OWN, judged_rig
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.closing_speed import (
    CLOSING_SPEEDS,
    KEYS,
    MEASUREMENTS,
    MODELS,
    SPEEDS,
    free_table,
    measure,
    usual_table,
)
from firstcontact_lab.study.settings import StudySettings

PAPER_RIG = CONDITIONS["paper-rig"]


def test_free_speeds_are_spread_over_their_range() -> None:
    usual, free = (
        np.log(rig.speeds[rig.uses == OWN]).std()
        for rig in (judged_rig("edge", 0, 4, free_speed=free) for free in (False, True))
    )
    uniform = np.log(FREE_SPEED[1] / FREE_SPEED[0]) / np.sqrt(12)
    assert free == pytest.approx(np.hypot(usual, uniform), rel=0.25)


def test_each_measurement_is_scored_against_none(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("not measured", "exact", "± 20 %, error not stated")
    few = {name: MEASUREMENTS[name] for name in names}
    monkeypatch.setattr("firstcontact_lab.study.parts.closing_speed.MEASUREMENTS", few)
    subject = Subject(PAPER_RIG.name, Dataset(()))
    results = NOTHING.replace(measure(subject, StudySettings().quick(), Serial()).entries)
    judged = results[CLOSING_SPEEDS]
    assert judged is not None
    assert list(judged.scores) == list(SPEEDS)
    for kind in SPEEDS:
        for model in MODELS:
            scores = judged.scores[kind][model]
            assert tuple(scores) == names
            assert set(scores["exact"].scores) == set(KEYS)
            assert all(gain == (0.0, 0.0) for gain in scores["not measured"].gains.values())
            for one in scores.values():
                low, high = one.intervals[KEYS[0]]
                assert low <= one.scores[KEYS[0]] <= high
    for table in (usual_table(results), free_table(results)):
        assert table is not None
        assert len(table.lines) == len(MODELS) * len(names)


def test_recordings_are_not_judged() -> None:
    assert not measure(Subject("recordings", Dataset(())), StudySettings(), Serial()).entries
