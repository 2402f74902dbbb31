"""Parts on random rigs: rigs unlike all in training, and the scores on them."""

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.jobs import Serial
from firstcontact.twin import CONDITIONS
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.random_rigs import (
    CLOSING_SPEEDS,
    KEYS,
    MEASUREMENTS,
    METHODS,
    MODELS,
    PART,
    RANDOM_RIGS,
    SPEED_KEYS,
    SPEED_PART,
    SPEEDS,
    measure,
)
from firstcontact_lab.study.parts.random_rigs import measure_speed as measure_speeds
from firstcontact_lab.study.random_rigs import (
    ALIKE,
    BLOCK,
    EVERYDAY,
    FREE_SPEED,
    OWN,
    RANDOM,
    simulate_labelled_rig,
)


@pytest.mark.parametrize("name", ["gearbox", "compressive", "several"])
def test_a_rig_depends_on_its_arguments_alone(name: str) -> None:
    first, again, other = (simulate_labelled_rig(name, 0, seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(first.touches.signals, again.touches.signals)
    np.testing.assert_array_equal(first.shore_a, again.shore_a)
    assert not np.array_equal(first.shore_a[:5], other.shore_a[:5])


def test_no_session_or_object_is_both_learned_and_scored() -> None:
    rig = simulate_labelled_rig("edge", 0, 4)
    assert set(rig.uses) == {OWN, BLOCK, EVERYDAY, RANDOM}
    learned, scored = (set(rig.sessions[is_use]) for is_use in (rig.uses == OWN, rig.uses != OWN))
    assert not learned & scored
    assert len(set(rig.objects[rig.uses == RANDOM])) > 20
    assert np.isinf(rig.radii[rig.uses == OWN]).all()


def test_a_rig_that_is_placed_alike_or_quiet_differs_in_nothing_else() -> None:
    rig = simulate_labelled_rig("linear_pad", 0, 4)
    alike = simulate_labelled_rig("linear_pad", 0, 4, delay=ALIKE)
    quiet = simulate_labelled_rig("linear_pad", 0, 4, is_quiet=True)
    # A few contacts end before the first estimate with one delay, and not with the other.
    drawn, again = (
        set(zip(one.objects, one.shore_a, one.speeds, strict=True)) for one in (rig, alike)
    )
    assert len(drawn & again) > 0.95 * max(len(drawn), len(again))
    np.testing.assert_array_equal(quiet.speeds, rig.speeds)
    np.testing.assert_array_equal(quiet.shore_a, rig.shore_a)
    before = slice(0, rig.touches.lead // 2)
    loud, low = (one.touches.signals[:, before].std(axis=1).mean() for one in (rig, quiet))
    assert low < loud / 3


def test_each_method_is_scored_against_the_network() -> None:
    subject = Subject(CONDITIONS["paper-rig"].name, Dataset(()))
    results = NOTHING.replace(measure(subject, StudySettings().quick(), Serial()).entries)
    judged = results[RANDOM_RIGS]
    assert list(judged.methods) == list(METHODS)
    network = judged.methods["network"]
    assert set(network.scores) == set(KEYS)
    assert all(gain == (0.0, 0.0) for gain in network.gains.values())
    for scores in judged.methods.values():
        low, high = scores.intervals[f"{EVERYDAY} 5 ms"]
        assert low <= scores.scores[f"{EVERYDAY} 5 ms"] <= high
    for table in PART.made_tables(results):
        assert len(table.lines) == len(METHODS)


def test_free_speeds_are_spread_over_their_range() -> None:
    usual, free = (
        np.log(rig.speeds[rig.uses == OWN]).std()
        for rig in (simulate_labelled_rig("edge", 0, 4, free_speed=free) for free in (False, True))
    )
    uniform = np.log(FREE_SPEED[1] / FREE_SPEED[0]) / np.sqrt(12)
    assert free == pytest.approx(np.hypot(usual, uniform), rel=0.25)


def test_each_measurement_is_scored_against_none(monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("not measured", "exact", "± 20 %, error not stated")
    few = {name: MEASUREMENTS[name] for name in names}
    monkeypatch.setattr("firstcontact_lab.study.parts.random_rigs.MEASUREMENTS", few)
    subject = Subject(CONDITIONS["paper-rig"].name, Dataset(()))
    results = NOTHING.replace(measure_speeds(subject, StudySettings().quick(), Serial()).entries)
    judged = results[CLOSING_SPEEDS]
    assert list(judged.scores) == list(SPEEDS)
    for kind in SPEEDS:
        for model in MODELS:
            scores = judged.scores[kind][model]
            assert tuple(scores) == names
            assert set(scores["exact"].scores) == set(SPEED_KEYS)
            assert all(gain == (0.0, 0.0) for gain in scores["not measured"].gains.values())
            for one in scores.values():
                low, high = one.intervals[SPEED_KEYS[0]]
                assert low <= one.scores[SPEED_KEYS[0]] <= high
    for table in SPEED_PART.made_tables(results):
        assert len(table.lines) == len(MODELS) * len(names)
