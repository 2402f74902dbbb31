"""Household closings: the table's outcomes equal those of a policy that is simulated directly."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core import Block, Contact, Estimate, Finger
from firstcontact.streaming import ContactEvent, ContactWithdrawn, Event, Pipeline
from firstcontact_lab.grasping.hands import AdaptedHand, SlipWatch, adapt_to_hand
from firstcontact_lab.grasping.picks import (
    FullPickJob,
    Pick,
    simulate_approach,
    simulate_full_closing,
)
from firstcontact_lab.grasping.table import ClosingGrid, simulate_approach_outcomes

HOW = ClosingGrid((0.10,), (1.0, 3.0), (2.0,))
HAND = 4711


@pytest.fixture(scope="module")
def hands_by_pick() -> dict[tuple[int, float], AdaptedHand]:
    return {(HAND, 0.10): adapt_to_hand((HAND, 0.10), 6)}


def test_a_hand_knows_itself_by_its_own_blocks(
    hands_by_pick: dict[tuple[int, float], AdaptedHand],
) -> None:
    entry = hands_by_pick[HAND, 0.10]
    assert entry.pinches == 30
    assert entry.rmse < 10
    assert entry.detector.learns


@pytest.mark.parametrize("kind", ["raspberry", "soup can"])
def test_a_policy_in_the_loop_ends_as_the_table_says(
    kind: str, hands_by_pick: dict[tuple[int, float], AdaptedHand]
) -> None:
    pick = Pick(kind, HAND, 2)
    row = simulate_approach_outcomes((pick, 0.10), hands_by_pick, HOW)
    settings = {"force": 3.0, "approach": 0.10}
    computed = simulate_full_closing(FullPickJob(pick, "blind", settings), hands_by_pick)
    assert computed.damaged == bool(row.peak[1] > row.limit)
    if not computed.damaged:
        assert computed.largest == pytest.approx(row.peak[1], abs=1e-9)
        needed = row.mass * 9.80665 / row.friction
        assert computed.dropped == bool(row.hold[1] < needed)


def test_the_estimate_is_one_from_before_the_second_contact(
    hands_by_pick: dict[tuple[int, float], AdaptedHand],
) -> None:
    begun = simulate_approach(Pick("apple", HAND, 1), 0.10, hands_by_pick[HAND, 0.10])
    assert begun.heard >= begun.offset - 0.002
    assert all(a.elapsed <= begun.offset + 0.002 for a in begun.answers)
    if begun.estimate is not None:
        assert begun.estimate.value == begun.answers[-1].value


def test_estimates_of_a_withdrawn_contact_are_left_out(
    hands_by_pick: dict[tuple[int, float], AdaptedHand], monkeypatch: pytest.MonkeyPatch
) -> None:
    false = Contact(Finger.INDEX, 448, 450)
    guess = Estimate(
        value=0.0, low=0.0, high=9.0, level=0.9, elapsed=0.002, available=0.002, model="false",
        contact=false, complete=458, epoch=0, host=0.0, compute=0.0,
    )  # fmt: skip
    events = [
        ContactEvent(false, True, 0, 0.0),
        guess,
        ContactEvent(replace(false, finger=Finger.THUMB), False, 0, 0.0),
        ContactWithdrawn(false, 464, 0),
    ]

    class Clicking(Pipeline):
        def update(self, block: Block, host: float) -> Iterator[Event]:
            if block.first_sample <= 465 < block.end:
                yield from events
            yield from super().update(block, host)

    monkeypatch.setattr("firstcontact_lab.grasping.picks.Pipeline", Clicking)
    begun = simulate_approach(Pick("apple", HAND, 1), 0.10, hands_by_pick[HAND, 0.10])
    assert begun.offset is not None
    assert begun.heard == pytest.approx(begun.offset, abs=0.01)
    assert begun.answers
    assert all(a.contact.sample > false.sample for a in begun.answers)


def test_a_declared_slip_is_told_its_latency_late_and_again(
    hands_by_pick: dict[tuple[int, float], AdaptedHand],
) -> None:
    plant = simulate_approach(Pick("soup can", HAND, 1), 0.10, hands_by_pick[HAND, 0.10]).plant
    watch, predictions = SlipWatch(0.05), []
    while not plant.ended:
        plant.advance(5)
        if watch.slips(plant):
            predictions.append(plant.now)
    since = plant.slipping_since
    assert predictions[0] == pytest.approx(since + 0.05, abs=0.002)
    assert np.diff(predictions) == pytest.approx(np.full(len(predictions) - 1, 0.05), abs=0.003)
