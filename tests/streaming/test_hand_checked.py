"""A device's own answers beside the host's: the same, or how they differ."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import told_events
from told_events import ANSWER, DESCRIPTOR, FIRST, SECOND

from firstcontact.core import Block, Finger
from firstcontact.device import DeviceContact, DeviceEstimate, DevicePrediction
from firstcontact.streaming import PinchDone, TextSink
from firstcontact.streaming._event_json import of_event
from firstcontact.streaming._events import FromHand, HandPinch
from firstcontact.streaming._hand_answers import HandAnswers
from firstcontact.streaming._sink import Update

RATE = 4936.0
DONE = PinchDone(1, 400, 1600, 0, (FIRST, SECOND), (), (), RATE, answers=(ANSWER,))
TOLD: tuple[DevicePrediction, ...] = (
    *told_events.TOLD,
    DeviceEstimate(Finger.THUMB, 510, 74, 583, 99.0, 90.0, 100.0, False, False, 441e-6, 0),
    DeviceContact(Finger.INDEX, 580, 590, False, 0),
)


def pinches(
    told: tuple[DevicePrediction, ...], done: tuple[PinchDone, ...], checked: bool = True
) -> list[HandPinch]:
    answers = HandAnswers("0123456789abcdef", RATE, checked)
    for pinch in done:
        answers.done(pinch)
    events = []
    for k, t in enumerate(told):
        events += answers.came((t,), Block(np.zeros((10, 16), np.int16), 500 + 10 * k), 0.0)
    assert [e.told for e in events if isinstance(e, FromHand)] == list(told)
    assert not [e for e in events if isinstance(e, HandPinch)]  # it is not over yet
    events = answers.came((), Block(np.zeros((3000, 16), np.int16), 600), 0.0) + answers.ended()
    return [e for e in events if isinstance(e, HandPinch)]


def said(event: HandPinch) -> str:
    out = io.StringIO()
    sink = TextSink(out)
    sink.open(DESCRIPTOR)
    sink.take(Update(events=(event,)))
    return out.getvalue().splitlines()[-1]


def test_the_same_answers_are_said_to_be_the_same() -> None:
    (pinch,) = pinches(TOLD, (DONE,))
    assert pinch.standing == TOLD[1]  # the one after was made from samples of both
    assert pinch.check is not None
    assert pinch.check.same
    assert (pinch.check.compared, pinch.check.largest) == (1, 0.0)
    assert "30.5 Shore A (22 to 39) from 12 ms at 12.2 ms, the same here (1 answers)" in said(pinch)
    assert of_event(pinch)["check"]["same"] is True


def test_a_second_contact_that_is_placed_before_the_first_is_its_pinchs() -> None:
    # Its onset may be found further back than the first one's, which was known earlier.
    second = DeviceContact(Finger.INDEX, 500, 590, False, 0)
    own = replace(DONE, contacts=(FIRST, replace(SECOND, sample=500)), answers=())
    (pinch,) = pinches((TOLD[0], second), (own,))
    assert pinch.second == second
    assert pinch.check is not None
    assert pinch.check.contacts


def test_a_difference_is_told_with_its_size() -> None:
    own = replace(DONE, answers=(replace(ANSWER, high=39.25),))
    (pinch,) = pinches(TOLD, (own,))
    assert pinch.check is not None
    assert not pinch.check.same
    assert pinch.check.largest == 0.25
    assert "differs here: up to 0.25 Shore A apart" in said(pinch)


def test_other_contacts_are_told() -> None:
    moved = replace(DONE, contacts=(replace(FIRST, sample=511), SECOND))
    (pinch,) = pinches(TOLD, (moved,))
    assert pinch.check is not None
    assert not pinch.check.contacts
    assert "other contacts" in said(pinch)


def test_what_only_one_of_them_found_is_told() -> None:
    (alone,) = pinches((), (DONE,))
    assert (alone.first, alone.sample) == (None, 510)
    assert "no contact, differs here: other contacts" in said(alone)
    (alone,) = pinches(TOLD, ())
    assert alone.check is not None
    assert not alone.check.same


def test_without_a_model_here_nothing_is_checked() -> None:
    (pinch,) = pinches(TOLD, (DONE,), checked=False)
    assert pinch.check is None
    assert "not checked" in said(pinch)
    assert of_event(pinch)["check"] is None


def test_a_pinch_in_a_gap_of_the_host_was_not_heard_here() -> None:
    answers = HandAnswers("0123456789abcdef", RATE, checked=True)
    answers.came((), Block(np.zeros((400, 16), np.int16), 0), 0.0)
    events = answers.came(TOLD, Block(np.zeros((9000, 16), np.int16), 700), 0.0)
    (pinch,) = [e for e in events if isinstance(e, HandPinch)]
    assert "not heard here: samples were lost" in said(pinch)
    assert pinch.check is not None
    assert pinch.check.lost


def test_answers_that_belong_to_no_pinch_are_not_kept() -> None:
    """A device that never tells a first contact, or tells one of long ago, costs no memory."""
    answers = HandAnswers("0123456789abcdef", RATE, checked=True)
    second = replace(TOLD[3], first=False)
    for k in range(100):
        block = Block(np.zeros((50, 16), np.int16), 10_000 + 50 * k)
        events = answers.came((second, TOLD[1]), block, 0.0)
        assert [e.told for e in events if isinstance(e, FromHand)] == [second, TOLD[1]]
    assert answers._told == []
