"""Tests of the outcome: held, dropped, squeezed or broken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pinches import SEED
from plants import closed, plant

from firstcontact.core import FINGERTIP_RATE, GRAVITY, Command
from firstcontact.twin import BLOCKS, BRITTLE, Drive, TwinObject, block, generator
from firstcontact.twin._objects import Fragility
from firstcontact.twin._outcome import stable_since

_, CRISP, BERRY = BRITTLE


def test_open_hand_never_lifts_the_object() -> None:
    hand = plant(BLOCKS[1], 0, Drive(latency=0.0))
    closed(hand, Command(-0.1, 12.0))
    outcome = hand.outcome
    assert outcome.first_contact is outcome.second_contact is outcome.time_to_grasp is None
    assert outcome.dropped
    assert outcome.peak_force == outcome.squeeze == outcome.slipped == 0
    assert len(hand.advance(100)) == 0


def test_gentler_commands_press_and_squeeze_less() -> None:
    outcomes = []
    for share, force in ((1.0, 12.0), (1.0, 5.0), (0.4, 5.0)):
        hand = plant(block(5), 1)
        closed(hand, Command(share * hand.nominal.speed, force))
        outcomes.append(hand.outcome)
        assert not hand.outcome.dropped
        assert hand.outcome.time_to_grasp is not None
    peaks = [o.peak_force for o in outcomes]
    assert peaks == sorted(peaks, reverse=True)
    assert [o.squeeze for o in outcomes] == sorted((o.squeeze for o in outcomes), reverse=True)


@pytest.mark.parametrize("share", [0.9, 0.97, 1.03, 1.1])
def test_object_drops_exactly_when_friction_is_below_its_weight(share: float) -> None:
    force = 4.0
    just = 2 * BLOCKS[2].nominal.face_mass * GRAVITY / (2 * force)
    kind = replace(BLOCKS[2], friction=just * share)
    hand = plant(kind, 2)
    closed(hand, Command(hand.nominal.speed, force))
    # The clamp takes a little of one finger's force: well below the steps of share.
    assert hand.outcome.dropped == (share < 1)
    assert (hand.outcome.slipped > 1e-4) == (share < 1)


def test_grasp_is_stable_from_when_it_stays_strong_and_steady() -> None:
    t = np.arange(3000) / FINGERTIP_RATE
    rising = np.minimum(100 * t, 4.0)
    at = stable_since(rising, 2.0)
    assert at is not None
    assert at / FINGERTIP_RATE == pytest.approx(0.04, abs=0.021)
    assert stable_since(rising, 4.0) is None, "not strong enough"
    assert stable_since(rising[:10], 1.0) is None
    assert stable_since(4 + np.sin(2 * np.pi * 11 * t), 1.0) is None, "it swings"
    late = rising.copy()
    late[2000:2300] = 1.0
    later_start = stable_since(late, 2.0)
    assert later_start is not None
    assert later_start >= 2300


@pytest.mark.parametrize("kind", BRITTLE, ids=lambda k: k.name)
def test_object_breaks_when_a_contact_force_exceeds_its_limit(kind: TwinObject) -> None:
    for number in range(4):
        for command in (Command(0.13, 12.0), Command(0.02, 1.0)):
            hand = plant(kind, number)
            closed(hand, command)
            unbreakable = plant(replace(kind, fragility=None), number)
            closed(unbreakable, command)
            outcome = hand.outcome
            assert outcome.broken == (unbreakable.forces.max() > hand.limit)
            assert not unbreakable.outcome.broken
            if outcome.broken:
                assert outcome.time_to_grasp is None
                # Within what a force rises by in a sample.
                assert outcome.peak_force < 1.3 * hand.limit
                collapsed_forces = hand.forces[hand._run.broken_at - 90 :][:5]
                assert collapsed_forces.max() < 0.6 * hand.limit, "its force collapses"


def test_breaking_force_has_a_weibull_distribution() -> None:
    fragility = Fragility(2.2, 4.0)
    rng = generator(SEED, "fragility")
    limits = np.array([fragility.draw(rng) for _ in range(20_000)])
    assert (limits < 2.2).mean() == pytest.approx(1 - np.exp(-1), abs=0.012)
    assert limits.std() / limits.mean() == pytest.approx(0.28, abs=0.01)
    assert plant(CRISP, 5).limit == plant(CRISP, 5).limit != plant(CRISP, 6).limit
