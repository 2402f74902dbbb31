"""Tests of the outcome (held, dropped, squeezed or broken), and of the slip of a lifted object."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from pinches import BRITTLE, SEED, closed, drawn, plant

from firstcontact.core import Command
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.core.physics import GRAVITY, holding_force
from firstcontact.twin import BLOCKS, TwinObject
from firstcontact.twin.draw import generator
from firstcontact.twin.drive import Drive
from firstcontact.twin.objects import Fragility, block
from firstcontact.twin.outcome import Lift, slide, stable_since
from firstcontact.twin.plant import GraspPlant

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
    assert at / FINGERTIP_RATE == pytest.approx(0.04, abs=0.021)
    assert stable_since(rising, 4.0) is None, "not strong enough"
    assert stable_since(rising[:10], 1.0) is None
    assert stable_since(4 + np.sin(2 * np.pi * 11 * t), 1.0) is None, "it swings"
    late = rising.copy()
    late[2000:2300] = 1.0
    later_start = stable_since(late, 2.0)
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


def slide_states(
    forces: NDArray[np.float64], hanging: NDArray[np.float64], mass: float, friction: float
) -> NDArray[np.float64]:
    """Return distance and speed of the slip at each sample, shape (samples, 2)."""
    out = np.empty((len(forces), 2))
    slide(forces, hanging, mass, friction, 1 / FINGERTIP_RATE, np.zeros(2), out)
    return out


@pytest.mark.parametrize("grip_share", [0.0, 0.5, 0.9, 1.0, 1.5])
def test_sliding_is_free_fall_minus_friction(grip_share: float) -> None:
    mass, friction, n = 0.2, 0.5, 1000
    force = grip_share * holding_force(mass, friction)
    distance, speed = slide_states(np.full((n, 2), force), np.ones(n), mass, friction)[-1]
    time = n / FINGERTIP_RATE
    pull = max(1 - grip_share, 0.0) * GRAVITY
    assert distance == pytest.approx(pull * time**2 / 2, abs=1e-12)
    assert speed == pytest.approx(pull * time, abs=1e-12)


def test_slide_ends_when_the_grip_returns() -> None:
    forces = np.zeros((3000, 2))
    forces[100:] = 3 * holding_force(0.1, 0.5)
    distance, speed = slide_states(forces, np.ones(3000), 0.1, 0.5)[-1]
    time = 100 / FINGERTIP_RATE
    assert speed == 0
    # Falls at g, then is braked at 2 g.
    assert distance == pytest.approx(GRAVITY * time**2 / 2 * 1.5, rel=0.02)


@given(st.floats(0.05, 0.99), st.floats(0.1, 1.0), st.integers(1, 400))
def test_gradual_lift_slips_when_the_load_exceeds_friction(
    grip_share: float, over: float, piece: int
) -> None:
    mass, friction, lift = 0.3, 0.6, Lift(0.1, over)
    n = lift.samples + 50
    forces = np.full((n, 2), grip_share * holding_force(mass, friction))
    hanging = lift.hanging(0, n)
    states = slide_states(forces, hanging, mass, friction)
    begin = int(np.argmax(states[:, 1] > 0)) / FINGERTIP_RATE
    assert begin == pytest.approx(lift.delay + grip_share * over, abs=3 / FINGERTIP_RATE)
    # The fall then grows with the cube of time: g t^3 / 6 over the ramp's length.
    t = lift.samples / FINGERTIP_RATE - begin
    expected = GRAVITY / over * t**3 / 6
    assert states[lift.samples, 0] == pytest.approx(expected, rel=0.05, abs=1e-5)
    parts = np.zeros((n, 2))
    for start in range(0, n, piece):
        part = slice(start, start + piece)
        slide(
            forces[part], lift.hanging(start, len(forces[part])), mass, friction,
            1 / FINGERTIP_RATE, parts[max(start - 1, 0)].copy(), parts[part],
        )  # fmt: skip
    assert np.array_equal(parts, states), "pieces give the same slide"


def test_lift_is_linear_or_abrupt() -> None:
    abrupt = Lift(0.1).hanging(0, 1000)
    assert abrupt.sum() == 1000 - Lift(0.1).begin
    assert set(abrupt) == {0.0, 1.0}
    slow = Lift(0.1, 0.05)
    shares = slow.hanging(-10, 1000)
    assert shares[slow.begin + 10] == 0
    assert shares[slow.samples + 10] == 1
    assert np.diff(shares).max() == pytest.approx(1 / (slow.samples - slow.begin))
    for make_lift in (Lift, lambda over: Lift(0.1, over)):
        with pytest.raises(ValueError, match=r"(delay|duration)=-0\.1"):
            make_lift(-0.1)


@pytest.mark.parametrize("over", [0.0, 0.5])
def test_slip_is_reported_during_it_and_a_firmer_grip_stops_it(over: float) -> None:
    kind = BLOCKS[2]
    just = holding_force(kind.mass, kind.friction)
    hand = GraspPlant(drawn(kind, 2), Drive(latency=0.0), kind, lift=Lift(0.45, over))
    hand.command(Command(hand.nominal.speed, 0.9 * just))
    began = None
    while not hand.ended:
        hand.advance(5)
        assert hand.slipped == hand.outcome.slipped
        if began is None and hand.slipping_since is not None:
            began = hand.slipping_since
            assert hand.now - 5 / FINGERTIP_RATE < began <= hand.now
            assert hand.grip == pytest.approx(0.9 * just, rel=0.05)
            hand.command(Command(hand.nominal.speed, 3 * just))
    contact = hand.outcome.first_contact
    assert began - contact == pytest.approx(0.45 + 0.9 * over, abs=0.02)
    assert hand.slipping_since is None
    assert 0 < hand.slipped < 0.01
    assert not hand.outcome.dropped


def test_copy_may_have_another_lift() -> None:
    kind = BLOCKS[2]
    plant = GraspPlant(drawn(kind, 2), Drive(), kind)
    plant.command(Command(plant.nominal.speed, 0.5 * holding_force(kind.mass, kind.friction)))
    plant.move(2000)
    copy = plant.copy(Lift(0.3, 0.2))
    expected = GraspPlant(drawn(kind, 2), Drive(), kind, lift=Lift(0.3, 0.2))
    expected.command(Command(plant.nominal.speed, 0.5 * holding_force(kind.mass, kind.friction)))
    while not expected.ended:
        expected.move(100)
    while not copy.ended:
        copy.move(expected.sample - 2000)
    assert copy.outcome == expected.outcome
    assert copy.outcome.dropped
    assert plant.outcome.slipped == 0
