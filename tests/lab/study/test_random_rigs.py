"""Part ``random_rigs``: random rigs, some unlike all in training, and the scores on them."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.core import Dataset, Serial
from firstcontact.twin import (
    CONDITIONS,
)
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.rigs import FAMILIES
from firstcontact_lab.study._random_rigs import (
    BLOCK,
    EVERYDAY,
    OWN,
    RANDOM,
    STRUCTURES,
    judged_rig,
)
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.random_rigs import (
    KEYS,
    METHODS,
    RANDOM_RIGS,
    errors_table,
    intervals_table,
    measure,
)
from firstcontact_lab.study.settings import StudySettings

PAPER_RIG = CONDITIONS["paper-rig"]


def test_every_family_that_no_network_was_trained_on_is_judged() -> None:
    assert set(FAMILIES) < set(STRUCTURES)


@pytest.mark.parametrize("name", ["gearbox", "compressive", "several"])
def test_a_rig_depends_on_its_arguments_alone(name: str) -> None:
    first, again, other = (judged_rig(name, 0, seed) for seed in (4, 4, 5))
    np.testing.assert_array_equal(first.touches.signals, again.touches.signals)
    np.testing.assert_array_equal(first.shore_a, again.shore_a)
    assert not np.array_equal(first.shore_a[:5], other.shore_a[:5])


def test_no_session_or_object_is_both_learned_and_scored() -> None:
    rig = judged_rig("edge", 0, 4)
    assert set(rig.uses) == {OWN, BLOCK, EVERYDAY, RANDOM}
    learned, scored = (set(rig.sessions[is_use]) for is_use in (rig.uses == OWN, rig.uses != OWN))
    assert not learned & scored
    assert len(set(rig.objects[rig.uses == RANDOM])) > 20
    assert np.isinf(rig.radii[rig.uses == OWN]).all()


def test_each_method_is_scored_against_the_network() -> None:
    subject = Subject(PAPER_RIG.name, Dataset(()))
    results = NOTHING.replace(measure(subject, StudySettings().quick(), Serial()).entries)
    judged = results[RANDOM_RIGS]
    assert judged is not None
    assert list(judged.methods) == list(METHODS)
    network = judged.methods["network"]
    assert set(network.scores) == set(KEYS)
    assert all(gain == (0.0, 0.0) for gain in network.gains.values())
    for scores in judged.methods.values():
        low, high = scores.intervals[f"{EVERYDAY} 5 ms"]
        assert low <= scores.scores[f"{EVERYDAY} 5 ms"] <= high
    for table in (errors_table(results), intervals_table(results)):
        assert table is not None
        assert len(table.lines) == len(METHODS)


def test_recordings_are_not_judged() -> None:
    assert not measure(Subject("recordings", Dataset(())), StudySettings(), Serial()).entries
