"""Tests of the plant: samples like a device's, for all commands and step sizes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pinches import BRITTLE, COMMANDS, EVERYDAY, PAPER_RIG, closed, drawn, plant, simulated

from firstcontact.core import ChannelKind, Command, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin import BLOCKS, TwinObject
from firstcontact.twin.draw import Condition
from firstcontact.twin.drive import Drive
from firstcontact.twin.objects import block
from firstcontact.twin.outcome import LIFT, Lift
from firstcontact.twin.pinch import DURATION
from firstcontact.twin.plant import WATCHED, GraspPlant

LAYOUT = fingertip_layout()
_, CRISP, BERRY = BRITTLE


@pytest.mark.parametrize("number", range(3))
def test_plant_without_commands_equals_simulate(number: int) -> None:
    kind = BLOCKS[number]
    hand = GraspPlant(
        drawn(kind, number), Drive(back_damping=0.0), kind, longest=DURATION, lift=Lift(1.0)
    )
    expected = simulated(kind, number)
    assert closed(hand, piece=7).tobytes() == expected.data.tobytes()
    outcome = hand.outcome
    contacts = [c.sample / FINGERTIP_RATE for c in expected.truth]
    assert [outcome.first_contact, outcome.second_contact] == contacts


def test_plant_ends_after_the_lift() -> None:
    hand = plant(BLOCKS[1])
    assert hand.now == 0
    data = closed(hand, hand.nominal, 5)
    assert len(data) == hand.sample
    assert hand.now == (hand.sample - 1) / FINGERTIP_RATE
    outcome = hand.outcome
    assert hand.now == pytest.approx(outcome.first_contact + LIFT + WATCHED, abs=6 / FINGERTIP_RATE)
    strips = data[:, LAYOUT.columns(ChannelKind.STRIP)]
    contact_sample = strips.any(axis=1).argmax()
    assert contact_sample / FINGERTIP_RATE == outcome.first_contact


@settings(max_examples=25)
@given(
    st.sampled_from((*BRITTLE, BLOCKS[4], block(5))),
    st.sampled_from((PAPER_RIG, EVERYDAY)),
    st.sampled_from((0.0, 0.02)),
    st.lists(st.tuples(st.integers(5, 400), COMMANDS), max_size=8),
)
def test_any_commands_give_a_finite_outcome(
    kind: TwinObject, condition: Condition, latency: float, commands: list[tuple[int, Command]]
) -> None:
    hand = GraspPlant(drawn(kind, 1, condition), Drive(latency=latency), kind)
    for samples, command in commands:
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


COMMAND_LISTS = st.lists(st.tuples(st.integers(1, 700), COMMANDS), min_size=1, max_size=5)


@settings(max_examples=15)
@given(COMMAND_LISTS, st.sampled_from([0.0, 0.02]), st.integers(1, 300))
def test_samples_made_ahead_follow_later_commands(
    commands: list[tuple[int, Command]], latency: float, piece: int
) -> None:
    def run_plant(step: int, reads: bool) -> tuple[list[bytes], object]:
        hand = plant(BERRY, 3, Drive(latency=latency))
        for samples, command in commands:
            stop = hand.sample + samples
            while hand.sample < stop:
                (hand.advance if reads else hand.move)(min(step, stop - hand.sample))
            hand.command(command)
        state = [hand.forces.tobytes(), hand.slipped, hand.grip]
        remainder = hand.advance(500)
        return [*state, remainder.tobytes()], hand.outcome

    assert run_plant(piece, reads=True) == run_plant(3000, reads=False)


@settings(max_examples=10)
@given(st.integers(0, 1500), st.lists(COMMANDS, min_size=1, max_size=2), st.booleans())
def test_copy_is_independent_and_equal(at: int, commands: list[Command], commanded: bool) -> None:
    def make_plant() -> GraspPlant:
        hand = plant(CRISP, 1, Drive(latency=0.0))
        if commanded:
            hand.command(Command(0.05, 1.0))
        hand.advance(at)
        return hand

    def finish(hand: GraspPlant) -> tuple[bytes, object]:
        parts = []
        for command in commands:
            hand.command(command)
            parts.append(hand.advance(300))
        return np.concatenate(parts).tobytes(), hand.outcome

    original = make_plant()
    copies = [original.copy(), original.copy()]
    assert finish(copies[0]) == finish(make_plant())
    assert finish(copies[1]) == finish(make_plant())
    assert finish(original) == finish(make_plant())
    assert [f.outcome for f in copies] == [original.outcome] * 2
