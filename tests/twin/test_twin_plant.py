"""The plant sends what a device sends, and what becomes of the object is the mechanics'."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pinches import SEED, drawn, simulated

from firstcontact.core.command import Command
from firstcontact.core.layout import FINGERTIP_RATE, ChannelKind, fingertip_layout
from firstcontact.core.physics import GRAVITY, holding_force
from firstcontact.twin._outcome import slide, stable_from
from firstcontact.twin.conditions import EVERYDAY, PAPER_RIG, Condition
from firstcontact.twin.draw import generator
from firstcontact.twin.drive import Drive
from firstcontact.twin.lift import LIFT, Lift
from firstcontact.twin.objects import BLOCKS, BRITTLE, Fragility, TwinObject, block
from firstcontact.twin.pinch import DURATION
from firstcontact.twin.plant import WATCHED, GraspPlant
from firstcontact.twin.run import QUICK
from firstcontact.twin.sensor import OPTIMISTIC, VelostatParameters

LAYOUT = fingertip_layout()
_, CRISP, BERRY = BRITTLE


def plant(
    kind: TwinObject, number: int = 0, drive: Drive | None = None,
    velostat: VelostatParameters | None = None,
) -> GraspPlant:  # fmt: skip
    return GraspPlant(drawn(kind, number), drive or Drive(), kind, velostat)


def closed(hand: GraspPlant, command: Command | None = None, piece: int = 50) -> NDArray[np.int16]:
    if command is not None:
        hand.command(command)
    blocks = []
    while not hand.ended:
        blocks.append(hand.advance(piece))
    return np.concatenate(blocks)


@pytest.mark.parametrize("number", range(3))
def test_never_commanded_it_sends_what_simulate_sends(number: int) -> None:
    kind = BLOCKS[number]
    hand = GraspPlant(
        drawn(kind, number), Drive(back_damping=0.0), kind, longest=DURATION, lift=Lift(1.0)
    )
    expected = simulated(kind, number)
    assert closed(hand, piece=7).tobytes() == expected.data.tobytes()
    outcome = hand.outcome
    contacts = [c.sample / FINGERTIP_RATE for c in expected.truth]
    assert [outcome.first_contact, outcome.second_contact] == contacts


@settings(max_examples=10)
@given(st.integers(1, 400), st.sampled_from([0.0, 0.02, 0.08]))
def test_same_draw_and_commands_same_bytes_however_it_is_advanced(
    piece: int, latency: float
) -> None:
    def whole(step: int) -> tuple[bytes, object]:
        hand = plant(BERRY, 3, Drive(latency=latency))
        parts = []
        while hand.sample < 2400:
            if hand.sample == 600:
                hand.command(Command(0.04, 2.0))
            stop = 600 if hand.sample < 600 else 2400
            parts.append(hand.advance(min(step, stop - hand.sample)))
        return np.concatenate(parts).tobytes(), hand.outcome

    assert whole(piece) == whole(2400)


@pytest.mark.parametrize("latency", [0.0, 0.02])
def test_the_future_is_not_made_before_it_can_be_commanded(latency: float) -> None:
    drive = Drive(latency=latency)
    one, other = plant(BLOCKS[2], 0, drive), plant(BLOCKS[2], 0, drive)
    other.command(Command(other.nominal.speed, drive.force))
    one.command(Command(one.nominal.speed, drive.force))
    for hand in (one, other):
        for _ in range(60):
            hand.advance(5)
    one.command(Command(-0.2, 12.0))
    a, b = (np.concatenate([h.advance(5) for _ in range(100)]) for h in (one, other))
    first = int((a != b).any(axis=1).argmax())
    assert first >= drive.delay
    assert first < drive.delay + 60


def test_numbers_go_on_and_it_ends_when_the_object_was_lifted_and_watched() -> None:
    hand = plant(BLOCKS[1])
    assert hand.now == 0
    data = closed(hand, hand.nominal, 5)
    assert len(data) == hand.sample
    assert hand.now == (hand.sample - 1) / FINGERTIP_RATE
    outcome = hand.outcome
    assert outcome.first_contact is not None
    assert hand.now == pytest.approx(outcome.first_contact + LIFT + WATCHED, abs=6 / FINGERTIP_RATE)
    strips = data[:, LAYOUT.columns(ChannelKind.STRIP)]
    first = strips.any(axis=1).argmax()
    assert first / FINGERTIP_RATE == outcome.first_contact


COMMANDS = st.builds(Command, st.floats(-0.5, 0.5), st.floats(-1.0, 30.0))


@settings(max_examples=25)
@given(
    st.sampled_from((*BRITTLE, BLOCKS[4], block(5))),
    st.sampled_from((PAPER_RIG, EVERYDAY)),
    st.sampled_from((0.0, 0.02)),
    st.lists(st.tuples(st.integers(5, 400), COMMANDS), max_size=8),
)
def test_whatever_is_commanded_it_stays_finite_and_ends(
    kind: TwinObject, condition: Condition, latency: float, told: list[tuple[int, Command]]
) -> None:
    hand = GraspPlant(drawn(kind, 1, condition), Drive(latency=latency), kind)
    for samples, command in told:
        hand.advance(samples)
        hand.command(command)
    closed(hand)
    outcome = hand.outcome
    assert 0 <= outcome.peak_force < 40
    assert 0 <= outcome.squeeze < 0.1
    assert outcome.slipped >= 0
    assert outcome.time_to_grasp is None or 0 < outcome.time_to_grasp < 1
    assert outcome.time_to_grasp is None or not outcome.dropped
    assert not (outcome.broken and kind.fragility is None)


def test_an_open_hand_never_grasps_and_the_object_stays_behind() -> None:
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
def test_it_is_dropped_exactly_when_friction_holds_less_than_its_weight(share: float) -> None:
    force = 4.0
    just = 2 * BLOCKS[2].nominal.face_mass * GRAVITY / (2 * force)
    kind = replace(BLOCKS[2], friction=just * share)
    hand = plant(kind, 2)
    closed(hand, Command(hand.nominal.speed, force))
    # The clamp takes a little of one finger's force: well below the steps of share.
    assert hand.outcome.dropped == (share < 1)
    assert (hand.outcome.slipped > 1e-4) == (share < 1)


def slid(
    forces: NDArray[np.float64], hanging: NDArray[np.float64], mass: float, friction: float
) -> NDArray[np.float64]:
    """How far and how fast at each sample, shape (samples, 2)."""
    out = np.empty((len(forces), 2))
    slide(forces, hanging, mass, friction, 1 / FINGERTIP_RATE, np.zeros(2), out)
    return out


@pytest.mark.parametrize("held", [0.0, 0.5, 0.9, 1.0, 1.5])
def test_sliding_is_free_fall_less_friction(held: float) -> None:
    mass, friction, n = 0.2, 0.5, 1000
    each = held * holding_force(mass, friction)
    way, speed = slid(np.full((n, 2), each), np.ones(n), mass, friction)[-1]
    time = n / FINGERTIP_RATE
    pull = max(1 - held, 0.0) * GRAVITY
    assert way == pytest.approx(pull * time**2 / 2, abs=1e-12)
    assert speed == pytest.approx(pull * time, abs=1e-12)


def test_a_slide_ends_where_the_grip_comes_back() -> None:
    forces = np.zeros((3000, 2))
    forces[100:] = 3 * holding_force(0.1, 0.5)
    way, speed = slid(forces, np.ones(3000), 0.1, 0.5)[-1]
    time = 100 / FINGERTIP_RATE
    assert speed == 0
    # Falls at g, then is braked at 2 g.
    assert way == pytest.approx(GRAVITY * time**2 / 2 * 1.5, rel=0.02)


@given(st.floats(0.05, 0.99), st.floats(0.1, 1.0), st.integers(1, 400))
def test_under_a_gradual_lift_it_slips_when_the_hanging_share_passes_what_friction_holds(
    held: float, over: float, piece: int
) -> None:
    mass, friction, lift = 0.3, 0.6, Lift(0.1, over)
    n = lift.samples + 50
    forces = np.full((n, 2), held * holding_force(mass, friction))
    hanging = lift.hanging(0, n)
    whole = slid(forces, hanging, mass, friction)
    begin = int(np.argmax(whole[:, 1] > 0)) / FINGERTIP_RATE
    assert begin == pytest.approx(lift.after + held * over, abs=3 / FINGERTIP_RATE)
    # The fall then grows with the cube of time: g t^3 / 6 over the ramp's length.
    t = lift.samples / FINGERTIP_RATE - begin
    expected = GRAVITY / over * t**3 / 6
    assert whole[lift.samples, 0] == pytest.approx(expected, rel=0.05, abs=1e-5)
    parts = np.zeros((n, 2))
    for first in range(0, n, piece):
        here = slice(first, first + piece)
        slide(
            forces[here], lift.hanging(first, len(forces[here])), mass, friction,
            1 / FINGERTIP_RATE, parts[max(first - 1, 0)].copy(), parts[here],
        )  # fmt: skip
    assert np.array_equal(parts, whole), "it may be asked for piece by piece"


def test_a_lift_goes_evenly_and_an_abrupt_one_at_once() -> None:
    abrupt = Lift(0.1).hanging(0, 1000)
    assert abrupt.sum() == 1000 - Lift(0.1).begin
    assert set(abrupt) == {0.0, 1.0}
    slow = Lift(0.1, 0.05)
    shares = slow.hanging(-10, 1000)
    assert shares[slow.begin + 10] == 0
    assert shares[slow.samples + 10] == 1
    assert np.diff(shares).max() == pytest.approx(1 / (slow.samples - slow.begin))
    for bad in (Lift, lambda after: Lift(0.1, after)):
        with pytest.raises(ValueError, match="from 0 s on"):
            bad(-0.1)


def test_a_grasp_is_stable_when_it_is_strong_and_steady_from_then_on() -> None:
    t = np.arange(3000) / FINGERTIP_RATE
    rising = np.minimum(100 * t, 4.0)
    at = stable_from(rising, 2.0)
    assert at is not None
    assert at / FINGERTIP_RATE == pytest.approx(0.04, abs=0.021)
    assert stable_from(rising, 4.0) is None, "not strong enough"
    assert stable_from(rising[:10], 1.0) is None
    assert stable_from(4 + np.sin(2 * np.pi * 11 * t), 1.0) is None, "it swings"
    late = rising.copy()
    late[2000:2300] = 1.0
    again = stable_from(late, 2.0)
    assert again is not None
    assert again >= 2300


@pytest.mark.parametrize("kind", BRITTLE, ids=lambda k: k.name)
def test_it_breaks_when_a_contact_force_passes_its_limit(kind: TwinObject) -> None:
    for number in range(4):
        for command in (Command(0.13, 12.0), Command(0.02, 1.0)):
            hand = plant(kind, number)
            closed(hand, command)
            whole = plant(replace(kind, fragility=None), number)
            closed(whole, command)
            outcome = hand.outcome
            assert outcome.broken == (whole.forces.max() > hand.limit)
            assert not whole.outcome.broken
            if outcome.broken:
                assert outcome.time_to_grasp is None
                # Within what a force rises by in a sample.
                assert outcome.peak_force < 1.3 * hand.limit
                after = hand.forces[hand._run.broken_at - 90 :][:5]
                assert after.max() < 0.6 * hand.limit, "its force collapses"


def test_what_breaks_scatters_as_weibull_says() -> None:
    fragility = Fragility(2.2, 4.0)
    rng = generator(SEED, "fragility")
    limits = np.array([fragility.draw(rng) for _ in range(20_000)])
    assert (limits < 2.2).mean() == pytest.approx(1 - np.exp(-1), abs=0.012)
    assert limits.std() / limits.mean() == pytest.approx(0.28, abs=0.01)
    assert plant(CRISP, 5).limit == plant(CRISP, 5).limit != plant(CRISP, 6).limit


def test_an_optimistic_sheet_feels_the_same_pinch_sooner() -> None:
    columns = list(LAYOUT.columns(ChannelKind.FORCE))
    felt, heard = [], []
    for sheet in (None, OPTIMISTIC):
        hand = plant(BLOCKS[1], 0, velostat=sheet)
        data = closed(hand, hand.nominal)
        loud = data[:, columns].max(axis=1).astype(int)
        felt.append(int(np.argmax(loud > loud[:100].max() + 600)))
        heard.append(data[:, :2].tobytes())
    assert heard[0] == heard[1], "the motion is the same"
    assert felt[1] < felt[0] - 0.01 * FINGERTIP_RATE


def test_a_plant_too_short_for_its_pinch_is_refused() -> None:
    with pytest.raises(ValueError, match="before the second contact"):
        GraspPlant(drawn(BLOCKS[0]), Drive(), BLOCKS[0], longest=0.13)


TOLD = st.lists(st.tuples(st.integers(1, 700), COMMANDS), min_size=1, max_size=5)


@settings(max_examples=15)
@given(TOLD, st.sampled_from([0.0, 0.02]), st.integers(1, 300))
def test_what_was_made_ahead_is_made_again_where_a_command_changes_it(
    told: list[tuple[int, Command]], latency: float, piece: int
) -> None:
    def whole(step: int, reads: bool) -> tuple[list[bytes], object]:
        hand = plant(BERRY, 3, Drive(latency=latency))
        for samples, command in told:
            stop = hand.sample + samples
            while hand.sample < stop:
                (hand.advance if reads else hand.move)(min(step, stop - hand.sample))
            hand.command(command)
        seen = [hand.forces.tobytes(), hand.gaps.tobytes(), hand.slipped, hand.grip]
        rest = hand.advance(500)
        return [*seen, rest.tobytes()], hand.outcome

    assert whole(piece, reads=True) == whole(3000, reads=False)


@settings(max_examples=10)
@given(st.integers(0, 1500), st.lists(COMMANDS, min_size=1, max_size=2), st.booleans())
def test_a_copy_goes_on_as_the_plant_would_have_and_leaves_it_alone(
    at: int, commands: list[Command], commanded: bool
) -> None:
    def begun() -> GraspPlant:
        hand = plant(CRISP, 1, Drive(latency=0.0))
        if commanded:
            hand.command(Command(0.05, 1.0))
        hand.advance(at)
        return hand

    def ended(hand: GraspPlant) -> tuple[bytes, object]:
        parts = []
        for command in commands:
            hand.command(command)
            parts.append(hand.advance(300))
        return np.concatenate(parts).tobytes(), hand.outcome

    one = begun()
    copies = [one.copy(), one.copy()]
    assert ended(copies[0]) == ended(begun())
    assert ended(copies[1]) == ended(begun())
    assert ended(one) == ended(begun())
    assert [f.outcome for f in copies] == [one.outcome] * 2


@pytest.mark.parametrize("kind", [*BRITTLE, BLOCKS[0], BLOCKS[4]], ids=lambda k: k.name)
def test_quick_steps_change_no_force_by_much(kind: TwinObject) -> None:
    hands = []
    for steps in (None, QUICK):
        hand = GraspPlant(
            drawn(kind, 4), Drive(), replace(kind, fragility=None), lift=Lift(over=0.3),
            calm_steps=steps,
        )  # fmt: skip
        for force in (1.0, 3.0, 6.0):
            hand.command(Command(0.05, force))
            hand.move(1000)
        while not hand.ended:
            hand.move(50)
        hands.append(hand)
    fine, quick = (h.forces for h in hands)
    assert np.abs(quick - fine).max() < 1e-3 * fine.max()
    assert hands[0].outcome.held == hands[1].outcome.held


@pytest.mark.parametrize("over", [0.0, 0.5])
def test_the_slip_is_known_while_it_goes_on_and_a_firmer_grip_stops_it(over: float) -> None:
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
    assert began is not None
    contact = hand.outcome.first_contact
    assert contact is not None
    assert began - contact == pytest.approx(0.45 + 0.9 * over, abs=0.02)
    assert hand.slipping_since is None
    assert 0 < hand.slipped < 0.01
    assert hand.outcome.held


@pytest.mark.parametrize("shore_a", [5, 12.5, 70])
def test_blocks_of_any_hardness_are_the_papers(shore_a: float) -> None:
    made = block(shore_a)
    assert made.shore_a == shore_a
    assert made.mass == pytest.approx(0.189, abs=1e-3)
    assert block(10) == BLOCKS[0]


def test_a_copy_may_be_lifted_otherwise() -> None:
    kind = BLOCKS[2]
    begun = GraspPlant(drawn(kind, 2), Drive(), kind)
    begun.command(Command(begun.nominal.speed, 0.5 * holding_force(kind.mass, kind.friction)))
    begun.move(2000)
    other = begun.copy(Lift(0.3, 0.2))
    expected = GraspPlant(drawn(kind, 2), Drive(), kind, lift=Lift(0.3, 0.2))
    expected.command(Command(begun.nominal.speed, 0.5 * holding_force(kind.mass, kind.friction)))
    while not expected.ended:
        expected.move(100)
    while not other.ended:
        other.move(expected.sample - 2000)
    assert other.outcome == expected.outcome
    assert other.outcome.dropped
    assert begun.outcome.slipped == 0


@pytest.mark.parametrize("force", [0.6, 2.0, 8.0])
def test_other_specimens_are_judged_by_the_same_forces(force: float) -> None:
    kind = BERRY
    own = replace(kind, fragility=Fragility(3.0, math.inf))
    hands = [GraspPlant(drawn(kind, 3), Drive(), k) for k in (own, replace(kind, fragility=None))]
    for hand in hands:
        hand.command(Command(0.05, force))
        while not hand.ended:
            hand.move(100)
    broken, whole = hands
    assert whole.judged(replace(kind, fragility=None)) == whole.outcome
    judged = whole.judged(own)
    assert judged.broken == broken.outcome.broken == (whole.forces.max() > 3.0)
    assert judged.peak_force == broken.outcome.peak_force
    slippery = replace(kind, fragility=None, friction=0.01)
    assert whole.judged(slippery).dropped == (0.02 * force < kind.mass * GRAVITY)
