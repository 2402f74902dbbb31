"""Live events drive a hand: what it is told, when, and what came too late."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from told_events import ANSWER, ESTIMATE, FIRST, SECOND

from firstcontact.contact import Detector
from firstcontact.core import Block, Command, Dataset, fingertip_layout
from firstcontact.device import TransportDelay
from firstcontact.grasp import Grip, live_policies, live_policy
from firstcontact.grasp._printing import PrintHand
from firstcontact.streaming import (
    Armed,
    Estimated,
    Grasping,
    ModelWithInterval,
    PinchDone,
    Pipeline,
    Settled,
    Touched,
    grasp_lines,
)
from firstcontact.streaming._events import Event

LAYOUT = fingertip_layout()
FRAME = 5
RATE = LAYOUT.rate


def drive(
    pinches: Dataset, pipeline: Pipeline, grasping: Grasping, host: Callable[[], float]
) -> list[Event]:
    """Feed pinches as a session does, each an epoch."""
    events: list[Event] = []
    for epoch, pinch in enumerate(pinches.pinches):
        for i in range(0, len(pinch.data), FRAME):
            block = Block(pinch.data[i : i + FRAME], pinch.first_sample + i, epoch)
            for event in pipeline.update(block, host()):
                grasping.happened(event)
                events.append(event)
            grasping.came(block)
    for event in pipeline.finish():
        grasping.happened(event)
        events.append(event)
    return events


def still() -> float:
    """A clock for which computing takes no time."""
    return 0.0


@pytest.fixture
def hand() -> PrintHand:
    return PrintHand(out=io.StringIO())


@pytest.mark.parametrize("name", live_policies())
def test_every_policy_closes_first_and_stays_within_its_grip(
    name: str, hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    grip = Grip()
    grasping = Grasping(live_policy(name, grip), hand, LAYOUT)
    pipeline = Pipeline(LAYOUT, detector, models, clock=still)
    with hand:
        events = drive(fresh, pipeline, grasping, still)
        told = list(hand.told)
    assert grasping.loop.counts.closings == sum(isinstance(e, Armed) for e in events)
    assert grasping.loop.counts.contacts == sum(isinstance(e, PinchDone) for e in events) > 0
    assert grasping.loop.counts.commands == len(told) > 0
    for command in told:
        assert isinstance(command, Command)
        assert abs(command.speed) <= grip.speed
        assert 0 <= command.force <= grip.force


def test_the_estimate_is_acted_upon_with_the_sample_that_brings_it(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    grip = Grip()
    grasping = Grasping(live_policy("first_contact", grip), hand, LAYOUT)
    pipeline = Pipeline(LAYOUT, detector, models[-1:], clock=still)
    with hand:
        for event in drive(fresh.take([0]), pipeline, grasping, still):
            if isinstance(event, Touched) and event.first:
                contact = event.contact
            if isinstance(event, Estimated) and event.used:
                expected = grip.command_for(min(event.low, event.value))
                assert event.contact == contact
                assert grasping.last == expected
                assert grasping.loop.counts.estimates == 1
    assert grasping.loop.counts.misses == 0


def test_what_comes_after_the_deadline_is_a_miss_and_the_fallback_holds(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    grip = Grip()
    # A deadline that the window alone takes longer than.
    grasping = Grasping(live_policy("first_contact", grip), hand, LAYOUT, deadline=0.005)
    pipeline = Pipeline(LAYOUT, detector, models[-1:], clock=still)
    with hand:
        events = drive(fresh, pipeline, grasping, still)
    contacts = sum(isinstance(e, PinchDone) for e in events)
    counts = grasping.loop.counts
    assert (counts.misses, counts.estimates) == (contacts, 0)
    assert counts.unused == sum(isinstance(e, Estimated) for e in events)
    assert grasping.last == grip.gentle


def test_a_slow_computer_misses_the_deadline(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    policy = live_policy("first_contact")
    assert policy.deadline is not None
    grasping = Grasping(policy, hand, LAYOUT)
    # The estimate comes a whole deadline after the block that completed its window.
    pipeline = Pipeline(LAYOUT, detector, models[-1:], clock=lambda: policy.deadline or 0.0)
    with hand:
        events = drive(fresh, pipeline, grasping, still)
    used = [e for e in events if isinstance(e, Estimated) and e.used]
    assert len(used) > 0
    assert grasping.loop.counts.estimates == 0
    assert grasping.loop.counts.misses == grasping.loop.counts.contacts


def test_an_estimate_that_is_not_to_be_used_is_not(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    grip = Grip()
    grasping = Grasping(live_policy("first_contact", grip), hand, LAYOUT)
    pipeline = Pipeline(LAYOUT, detector, models[-1:], clock=still)
    with hand:
        events = drive(fresh, pipeline, grasping, still)
    used = sum(isinstance(e, Estimated) and e.used for e in events)
    assert 0 < used < sum(isinstance(e, Estimated) for e in events)
    assert grasping.loop.counts.estimates == used
    grasping.ended()
    assert hand.told[-1] is None  # released


def test_the_end_says_what_was_told(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    grasping = Grasping(live_policy("early_exit"), hand, LAYOUT)
    with hand:
        drive(fresh, Pipeline(LAYOUT, detector, models, clock=still), grasping, still)
    counts = grasping.loop.counts
    said = "\n".join(grasp_lines(grasping))
    for number in (counts.commands, counts.closings, counts.estimates, counts.misses):
        assert str(number) in said
    assert "time limit" not in "\n".join(grasp_lines(grasping, real_time=False))
    assert np.isfinite([c.force for c in hand.told if isinstance(c, Command)]).all()


def test_a_policy_is_told_the_one_answer_that_stands(hand: PrintHand) -> None:
    """However short its signal: no better one comes. What a fixed window says is left aside."""
    policy = live_policy("first_contact")
    grasping = Grasping(policy, hand, LAYOUT)
    settled = Settled(FIRST, ANSWER, 1, SECOND.decided, 0)
    begun = (Armed(400, 0), Touched(FIRST, True, 0, 0.0), ANSWER)
    with hand:
        for event in (*begun, settled, ESTIMATE, replace(settled, answer=replace(ANSWER, low=5.0))):
            grasping.happened(event)
    assert grasping.last == policy.grip.command_for(ANSWER.low)
    assert grasping.loop.counts.estimates == 1


def test_an_answer_out_of_range_is_as_none(hand: PrintHand) -> None:
    grasping = Grasping(live_policy("first_contact"), hand, LAYOUT)
    odd = replace(ANSWER, strange=True)
    settled = Settled(FIRST, odd, 0, 568, 0)
    with hand:
        for event in (Armed(400, 0), Touched(FIRST, True, 0, 0.0), odd, settled):
            grasping.happened(event)
    assert (grasping.loop.counts.estimates, grasping.loop.counts.unused) == (0, 1)


def test_samples_that_came_late_make_an_estimate_late(
    hand: PrintHand, fresh: Dataset, detector: Detector, models: list[ModelWithInterval]
) -> None:
    """Against those that came soonest: what is the same for all of them cannot be known."""
    counts = []
    for late in (0.0, 0.040):
        delay = TransportDelay(RATE)
        grasping = Grasping(live_policy("first_contact"), hand, LAYOUT, transport=delay)
        came = 0.0
        pipeline = Pipeline(LAYOUT, detector, models[-1:], clock=lambda: came)  # noqa: B023
        with hand:
            for pinch in fresh.pinches[:1]:
                for i in range(0, len(pinch.data), FRAME):
                    block = Block(pinch.data[i : i + FRAME], pinch.first_sample + i)
                    # The link stalls with the contact; all before came 3 ms after their time.
                    stalls = any(c.sample <= block.end for c in pinch.truth)
                    came = 100.0 + block.end / RATE + 0.003 + (late if stalls else 0.0)
                    grasping.arrived(block, came)
                    for event in pipeline.update(block, came):
                        grasping.happened(event)
                    grasping.came(block)
        counts.append(grasping.loop.counts)
    prompt, stalled = counts
    assert prompt.estimates == 1
    assert prompt.misses == 0
    assert stalled.estimates == 0
    assert stalled.misses == 1
