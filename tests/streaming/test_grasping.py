"""Live events that drive a hand: commands, their times, and late estimates."""

import io
from collections.abc import Callable
from typing import Any

import example_events
import numpy as np
import pytest
from example_events import ANSWER, FIRST_EVENT, SECOND_EVENT, START
from msgspec.structs import replace

import firstcontact as fc
from firstcontact.contact import Detector
from firstcontact.core import Block, Command, Contact, Dataset, fingertip_layout
from firstcontact.device.clock import TransportDelay
from firstcontact.grasp import Grip, Policy
from firstcontact.grasp.printing import PrintHand
from firstcontact.grasp.registry import live_policies, live_policy
from firstcontact.models import WindowPredictor
from firstcontact.models.anytime import PredictorLadder
from firstcontact.streaming import (
    ClosingStart,
    ContactEvent,
    Event,
    PinchDone,
    Pipeline,
    PolicyCommand,
)
from firstcontact.streaming.events import Estimate
from firstcontact.streaming.grasping import Grasping, PositionTrack

LAYOUT = fingertip_layout()
FRAME = 5
RATE = LAYOUT.rate


def drive(
    pinches: Dataset, pipeline: Pipeline, grasping: Grasping, host: Callable[[], float]
) -> list[Event]:
    """Feed pinches as a session does, each in its own epoch."""
    events: list[Event] = []
    for epoch, pinch in enumerate(pinches.pinches):
        for i in range(0, len(pinch.data), FRAME):
            block = Block(pinch.data[i : i + FRAME], pinch.first_sample + i, epoch)
            for event in pipeline.update(block, host()):
                grasping.on_event(event)
                events.append(event)
            grasping.after_block(block)
    for event in pipeline.finish():
        grasping.on_event(event)
        events.append(event)
    return events


def still() -> float:
    """Return a clock by which computing takes no time."""
    return 0.0


@pytest.fixture
def hand() -> PrintHand:
    return PrintHand(out=io.StringIO())


@pytest.mark.parametrize("name", live_policies())
def test_every_policy_closes_first_and_stays_within_its_grip(
    name: str, hand: PrintHand, fresh: Dataset, detector: Detector, models: list[WindowPredictor]
) -> None:
    grip = Grip()
    grasping = Grasping(live_policy(name, grip), hand, LAYOUT)
    pipeline = Pipeline(LAYOUT, detector, PredictorLadder(models), clock=still)
    with hand:
        events = drive(fresh, pipeline, grasping, still)
        predictions = list(hand.commands)
    assert grasping.loop.counts.closings == sum(isinstance(e, ClosingStart) for e in events)
    assert grasping.loop.counts.contacts == sum(isinstance(e, PinchDone) for e in events) > 0
    assert grasping.loop.counts.commands == len(predictions) > 0
    for command in predictions:
        assert abs(command.speed) <= grip.speed
        assert 0 <= command.force <= grip.force


def test_the_estimate_is_acted_upon_with_the_sample_that_brings_it(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[WindowPredictor]
) -> None:
    grip = Grip()
    grasping = Grasping(live_policy("first_contact", grip), hand, LAYOUT)
    pipeline = Pipeline(LAYOUT, detector, PredictorLadder(models[-1:]), clock=still)
    with hand:
        for event in drive(fresh.take([0]), pipeline, grasping, still):
            if isinstance(event, ContactEvent) and event.first:
                contact = event.contact
            if isinstance(event, Estimate):
                expected = grip.command_for(min(event.low, event.value))
                assert event.contact == contact
                assert grasping.last == expected
                assert grasping.loop.counts.estimates == 1
    assert grasping.loop.counts.misses == 0


@pytest.mark.parametrize("name", ["first_contact", "stiffness"])
def test_the_hand_acts_on_the_newest_estimate_in_range(name: str, hand: PrintHand) -> None:
    """Each estimate replaces the one before, and one that is out of range leaves none."""
    policy, grip = live_policy(name), Grip()
    grasping = Grasping(policy, hand, LAYOUT)
    early, newer = (
        replace(ANSWER, value=v, low=v - 1, high=v + 1, elapsed=at, available=at)
        for v, at in ((25.0, 0.003), (60.0, 0.008))
    )
    strange = replace(newer, out_of_range=True, elapsed=0.01)

    commands, counts = [], []
    with hand:
        final = replace(early, final=True)  # the newest one is from after the second contact
        for estimates in (
            (early,),
            (early, newer, replace(newer, final=True)),
            (early, strange),
            (early, strange, final),
        ):
            for event in (START, FIRST_EVENT, *estimates, SECOND_EVENT):
                grasping.on_event(event)
            commands.append(grasping.last)
            grasping.on_event(example_events.pinch(*estimates))
            counts.append((grasping.loop.counts.estimates, grasping.is_used))
    assert counts == [(1, True), (2, True), (2, False), (3, True)]
    soft, firm, unknown, again = (c.force for c in commands if c is not None)
    assert soft < firm
    assert unknown < firm
    assert again == soft
    if name == "first_contact":
        firm_command, soft_command = grip.command_for(59.0), grip.command_for(24.0)
        assert commands == [soft_command, firm_command, grip.gentle, soft_command]


def test_samples_that_came_late_make_an_estimate_late(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[WindowPredictor]
) -> None:
    """Delays count relative to the fastest samples. A constant delay cannot be detected."""
    counts = []
    for late in (0.0, 0.040):
        delay = TransportDelay(RATE)
        grasping = Grasping(live_policy("first_contact"), hand, LAYOUT, transport=delay)
        arrival = 0.0
        pipeline = Pipeline(LAYOUT, detector, PredictorLadder(models[-1:]), clock=lambda: arrival)  # noqa: B023
        with hand:
            for pinch in fresh.pinches[:1]:
                for i in range(0, len(pinch.data), FRAME):
                    block = Block(pinch.data[i : i + FRAME], pinch.first_sample + i)
                    # The link stalls with the contact; all before came 3 ms after their time.
                    stalls = any(c.sample <= block.end for c in pinch.truth)
                    arrival = 100.0 + block.end / RATE + 0.003 + (late if stalls else 0.0)
                    grasping.on_samples(block, arrival)
                    for event in pipeline.update(block, arrival):
                        grasping.on_event(event)
                    grasping.after_block(block)
        counts.append(grasping.loop.counts)
    prompt, stalled = counts
    assert prompt.estimates == 1
    assert prompt.misses == 0
    assert stalled.estimates == 0
    assert stalled.misses == 1


class ReportingHand(PrintHand):
    """Hand whose positions lie on a line through 0.1 m at 10 s, at uneven times."""

    position_rate = 100.0

    def __init__(self) -> None:
        super().__init__(out=io.StringIO())
        self.times: list[float] = []

    def positions(self) -> list[tuple[float, float]]:
        return [(at, 0.1 + 0.05 * (at - 10.0)) for at in self.times[-60:]]


@pytest.mark.parametrize("dtype", ["int16", "float32"])
def test_positions_are_kept_at_even_times_except_where_the_hand_was_silent(dtype: str) -> None:
    hand, rng = ReportingHand(), np.random.default_rng(0)
    track = PositionTrack(hand, dtype, epoch=3, start=10.0)
    assert track.read(0.0) == []
    even = 10.0 + np.arange(-5, 200) / 100
    times = even + rng.uniform(-0.004, 0.004, len(even))
    blocks: list[Block] = []
    for last in (10.2, 10.201, 10.5, 10.9, 11.4, 12.0):
        hand.times = [t for t in times if t < last and not 10.6 < t < 10.8]
        blocks += track.read(0.0)
    numbers = np.concatenate([b.first_sample + np.arange(len(b.data)) for b in blocks])
    assert set(np.diff(numbers)) - {1} == {np.diff(numbers).max()}
    assert numbers[0] == 1000
    assert numbers[-1] >= 1197
    silent = (numbers > 1062) & (numbers < 1078)
    assert not silent.any()
    values = np.concatenate([b.data[:, 0] for b in blocks]) * hand.position_resolution
    assert values == pytest.approx(0.1 + 0.05 * (numbers / 100 - 10.0), abs=5.1e-6)
    assert {(b.epoch, str(b.data.dtype)) for b in blocks} == {(3, dtype)}


def test_reports_at_the_even_times_themselves_are_kept() -> None:
    hand = ReportingHand()
    hand.position_rate = 60.0  # k / 60 * 60 is rounded up for some k
    track = PositionTrack(hand, "int16", epoch=0, start=0.0)
    blocks: list[Block] = []
    for k in range(600):
        hand.times.append(k * (1 / 60))
        blocks += track.read(0.0)
    numbers = np.concatenate([b.first_sample + np.arange(len(b.data)) for b in blocks])
    assert set(np.diff(numbers)) == {1}


def test_positions_beyond_the_samples_are_clipped() -> None:
    hand = ReportingHand()
    track = PositionTrack(hand, "int16", epoch=0, start=100.0)
    hand.times = [100.0, 100.01]
    (block,) = track.read(0.0)
    assert block.data.tolist() == [[32767], [32767]]


class Halting(Policy):
    """Policy of a user: it stops at the first contact."""

    def touched(self, contact: Contact, first: bool) -> Command | None:
        return Command(0.0, 1.0) if first else None


@pytest.mark.parametrize("policy", [Halting, Halting(Grip())])
def test_a_users_policy_drives_a_hand_and_its_commands_are_events(
    policy: type[Policy] | Policy, hand: PrintHand
) -> None:
    with fc.open("twin", speed=8.0) as source:
        events = list(fc.live(source, hand=hand, policy=policy, pinches=2))
    sent = [Command(e.speed, e.force) for e in events if isinstance(e, PolicyCommand)]
    assert sent == [x for x in hand.commands if x is not None]
    assert sent.count(Command(0.0, 1.0)) == 2


class Knowing(Halting):
    needs_truth = True


@pytest.mark.parametrize("policy", ["no such policy", "weight", Knowing, Knowing(Grip()), Grip, 7])
def test_a_policy_that_cannot_drive_a_hand_is_refused(policy: Any) -> None:
    with pytest.raises(fc.InputError) as caught:
        next(fc.live(fc.open("twin"), hand="print", policy=policy))
    assert caught.value.parameter == "policy"
    assert policy == "weight" or "weight" not in str(caught.value)  # only for simulations


def test_an_estimate_out_of_range_is_as_none(hand: PrintHand) -> None:
    grasping = Grasping(live_policy("first_contact"), hand, LAYOUT)
    odd = replace(ANSWER, out_of_range=True)
    with hand:
        for event in (START, FIRST_EVENT, odd, replace(odd, final=True)):
            grasping.on_event(event)
    assert (grasping.loop.counts.estimates, grasping.loop.counts.unused) == (0, 1)
    assert "no usable estimate" in "".join(grasping.lines())
