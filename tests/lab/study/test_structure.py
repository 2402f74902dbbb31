"""Rigs whose structure differs from the twin's: closings, false alarms and scores."""

import numpy as np
import pytest

from firstcontact.contact import ThresholdDetector
from firstcontact.core import Label
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.study.parts.structure import (
    PART,
    STRUCTURE,
    Counts,
    Structures,
    count_alarms,
    score_rigs,
    structure_table,
    unknown_table,
)
from firstcontact_lab.study.structures import (
    FREE,
    LEAD,
    REST,
    StructuredRig,
    draw_blocks,
    draw_empty,
    draw_objects,
    draw_structured,
)


@pytest.fixture(scope="module", params=["gearbox", "stepper"])
def rig(request: pytest.FixtureRequest) -> StructuredRig:
    return draw_structured(1, request.param)


def test_same_seed_gives_the_same_closings(rig: StructuredRig) -> None:
    again = draw_structured(1, rig.motor)
    one, other = draw_objects(rig, 2), draw_objects(again, 2)
    for a, b in zip(one, other, strict=True):
        assert np.array_equal(a.data, b.data)
        assert (a.truth, a.label) == (b.truth, b.label)
    assert not np.array_equal(one[0].data, one[1].data[: len(one[0].data)])


def test_closing_is_quiet_until_the_contact_and_loud_after_it(rig: StructuredRig) -> None:
    for pinch in draw_blocks(rig, (60.0,), 2, 1):
        assert pinch.second is not None
        free = pinch.first.sample / FINGERTIP_RATE - REST
        assert FREE[0] - 1e-3 <= free <= FREE[1] + 1e-3
        x = pinch.vibration()[:, pinch.layout.vibration_fingers.index(pinch.first.finger)]
        start = round(LEAD * FINGERTIP_RATE)
        earlier = x[pinch.first.sample - 4 * start : pinch.first.sample]
        later = x[pinch.first.sample : pinch.first.sample + start]
        assert np.abs(later - earlier.mean()).max() > 3 * earlier.std()


def test_alarms_count_on_nothing_only(rig: StructuredRig) -> None:
    empty = draw_empty(rig, 1, 1.0)
    assert empty[0].label == Label()
    deaf, minutes = count_alarms(ThresholdDetector(1e5), empty, confirm=True)
    sharp, same = count_alarms(ThresholdDetector(0.5), empty, confirm=False)
    assert (deaf, minutes) == (0, same)
    assert sharp > 0


def test_scores_are_ratios_over_all_rigs() -> None:
    one, other = Counts(), Counts()
    one.outcomes |= {"success": 8, "late": 1, "wrong_finger": 1}
    other.outcomes |= {"success": 10}
    one.alarms, one.minutes, other.minutes = 3, 1.0, 1.0
    one.estimates, other.estimates = 6, 10
    one.errors, other.errors = [160.0, 5.0, 40.0, 6.0], [0.0, 7.0, 24.0, 10.0]
    scores = score_rigs(np.array([one.row(), other.row()] * 3), 0)
    assert (scores.placed, scores.late, scores.missed, scores.early) == (0.9, 0.05, 0.05, 0.0)
    assert scores.false_alarms_per_minute == 1.5
    assert scores.rmse == pytest.approx(10**0.5)
    assert scores.combined == 2.0
    assert scores.gain == pytest.approx(2.0 - 10**0.5)
    assert (scores.coverage, scores.combined_coverage) == (0.75, 1.0)
    assert scores.predicted == 0.8
    low, high = scores.intervals["placed"]
    assert low <= 0.9 <= high
    structures = Structures(
        rigs=2, seeds=[1], pinches=10, detectors={"shipped": scores}, unknown_rig={"5": 9.0}
    )
    results = NOTHING.replace([STRUCTURE(structures)])
    for table in (structure_table(results), unknown_table(results)):
        assert len(table.lines) == 1
    assert not PART.by_default
