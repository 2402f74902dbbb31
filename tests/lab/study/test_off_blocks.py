"""Part ``generalise``: content of the sets, inputs of each model, and scores with closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.core.physics import gent_modulus
from firstcontact.jobs import Serial
from firstcontact.models.labelled_data import LabelledWindows
from firstcontact.models.registry import window_estimators
from firstcontact.twin import CONDITIONS
from firstcontact_lab.study.comparison import MASKED, NETWORK, Competitor, Query, answer
from firstcontact_lab.study.off_blocks import RigSetPredictions, score_off_blocks
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts import generalise as part
from firstcontact_lab.study.parts.generalise import (
    GENERALISE,
    objects_off_blocks,
    others_off_blocks,
)
from firstcontact_lab.study.rig_sets import PinchUse, RigSet, Sizes, rig_set

SIZES = Sizes(blocks=4, held_out=2, objects=3, other_blocks=2, kinds=4)


@pytest.fixture(scope="module")
def small() -> RigSet:
    return rig_set(1, CONDITIONS["paper-rig"], SIZES, [0, 2])


def test_a_set_has_every_use_and_shares_no_specimen_with_the_floor(small: RigSet) -> None:
    n = len(small.windows)
    assert len(small.touches) == len(small.uses) == len(small.radii) == n
    counts = {use: len(small.indices(use)) for use in PinchUse}
    assert min(counts.values()) > 0
    assert sum(counts.values()) == n
    specimens = small.windows.specimens
    floor = set(specimens[small.indices(PinchUse.KINDS)])
    assert not floor & set(specimens[small.indices(PinchUse.OBJECTS)])
    assert set(specimens[small.indices(PinchUse.OBJECTS)]) == set(
        specimens[small.indices(PinchUse.OTHER_OBJECTS)]
    )
    sessions = small.windows.sessions
    for use, other in ((PinchUse.BLOCKS, PinchUse.HELD), (PinchUse.OBJECTS, PinchUse.KINDS)):
        assert not set(sessions[small.indices(use)]) & set(sessions[small.indices(other)])


def test_who_is_told_the_modulus_errs_by_the_label_alone(small: RigSet) -> None:
    ask = small.indices(PinchUse.BLOCKS)
    predictions = Query(Competitor("modulus", "modulus"), 0, "any", ask[:0], ask)
    values = answer(predictions, [small], 0)
    assert np.abs(values - small.windows.y[ask]).max() < 12.0
    exact = replace(small, moduli=np.array([gent_modulus(s) for s in small.windows.y]))
    assert answer(predictions, [exact], 0) == pytest.approx(small.windows.y[ask])


def test_who_is_told_the_stiffness_learns_it_on_these_blocks(small: RigSet) -> None:
    learn, ask = small.indices(PinchUse.BLOCKS), small.indices(PinchUse.HELD)
    labelled_contacts = np.exp(small.windows.y / 20)
    predictions = Query(Competitor("contact_stiffness", "stiffness"), 0, "any", learn, ask)
    values = answer(predictions, [replace(small, stiffnesses=labelled_contacts)], 0)
    assert values == pytest.approx(small.windows.y[ask])


def answered(
    errors: dict[PinchUse, float], place: int = 0, question: str = "any"
) -> RigSetPredictions:
    """Return six predictions for each use in ``errors``, all with that use's error."""
    uses = np.repeat([use.value for use in errors], 6)
    wrong = np.repeat(list(errors.values()), 6)
    y = np.tile([30.0, 60.0], len(uses) // 2)
    names = np.array([f"thing {v:g}" for v in y])
    queries = LabelledWindows(
        np.zeros((len(y), 4, 1), np.float32), y, names, names, names,
        np.ones(len(y), bool), np.arange(len(y)), 4936.0,
    )  # fmt: skip
    return RigSetPredictions(question, place, queries, uses, y + wrong)


def test_scores_are_those_of_constant_errors() -> None:
    parts = [
        answered({PinchUse.OBJECTS: 4.0, PinchUse.HELD: -2.0}),
        answered({PinchUse.OTHER_OBJECTS: 3.0}),
        answered({PinchUse.BLOCKS: 1.0}, question="30"),
        answered({PinchUse.BLOCKS: 5.0}, question="60"),
    ]
    computed = score_off_blocks(parts, {}, 0)
    assert (computed.sets, computed.options, computed.intervals) == (1, None, {})
    assert (computed.objects, computed.three_pinches, computed.blocks) == pytest.approx((4, 4, 2))
    assert (computed.other_hand, computed.accuracy) == pytest.approx((3, 1))
    assert (computed.bias_softest, computed.bias_hardest) == pytest.approx((4, 4))
    assert computed.level_left_out == pytest.approx(3.0)  # the mean over levels


def test_three_pinches_average_what_cancels_out() -> None:
    entry = answered({PinchUse.OBJECTS: 0.0})
    signs = entry.values + np.tile([3.0, -3.0, 0.0], 2)
    computed = score_off_blocks([replace(entry, values=signs)], {}, 0)
    assert computed.three_pinches < computed.objects


def test_intervals_are_over_sets() -> None:
    errors = (1, 7, 1, 7, 1, 7)
    parts = [
        answered({PinchUse.OBJECTS: float(error)}, place) for place, error in enumerate(errors)
    ]
    computed = score_off_blocks(parts, {"epochs": 1}, 0)
    assert computed.sets == 6
    assert computed.objects == pytest.approx(5.0)
    low, high = computed.intervals["objects"]
    assert 1.0 <= low < 5.0 < high <= 7.0
    assert computed.other_hand is None


def test_every_competitor_is_scored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part, "BRIEF", SIZES)
    subject = Subject(CONDITIONS["paper-rig"].name, Dataset(()))
    outcome = part.generalise(subject, StudySettings().quick(), Serial())
    results = outcome.results[GENERALISE]
    assert (results.sets, results.floor.sets) == (1, 1)
    rows = window_estimators().items()
    fast = {n for n, e in rows if not e.baseline and not e.slow}
    assert fast | {entry.name for entry in (MASKED, *NETWORK)} == set(results.estimators)
    assert set(results.ceiling) == {"modulus", "contact_stiffness"}
    assert all(entry.other_hand is not None for entry in results.estimators.values())
    objects, remaining = (make(outcome.results) for make in (objects_off_blocks, others_off_blocks))
    assert len(objects.lines) == len(remaining.lines) + 1  # the floor knows objects alone
    for table in (objects, remaining):
        assert all(len(row.cells) == len(table.head) for row in table.lines)
    assert [figure.key for figure in outcome.figures] == ["generalise"]
