"""Comparison of a device's estimates with the host's."""

from dataclasses import replace

import example_events
import numpy as np
from example_events import ANSWER, OF_HAND
from example_events import pinch as pinch_of
from msgspec.structs import replace as changed

from firstcontact.core import Block, Finger
from firstcontact.device.descriptor import DeviceContact, DeviceEstimate, DevicePrediction
from firstcontact.streaming import HandPinch, HandPrediction, PinchDone
from firstcontact.streaming._hand_predictions import HandPredictions
from firstcontact.streaming.events import Estimate

RATE = 4936.0
DONE = pinch_of(ANSWER)
TOLD: tuple[DevicePrediction, ...] = (
    *example_events.MESSAGES,
    DeviceEstimate(Finger.THUMB, 510, 74, 583, 99.0, 90.0, 100.0, False, False, 441e-6, 0),
    DeviceContact(Finger.INDEX, 580, 590, False, 0),
)


def pinches(
    messages: tuple[DevicePrediction, ...],
    finished_pinch: tuple[PinchDone, ...],
    checked: bool = True,
) -> list[HandPinch]:
    predictions = HandPredictions("0123456789abcdef", RATE, checked)
    for pinch in finished_pinch:
        predictions.add_pinch(pinch)
    events = []
    for k, t in enumerate(messages):
        events += predictions.update((t,), Block(np.zeros((10, 16), np.int16), 500 + 10 * k), 0.0)
    assert [e.known_sample for e in events if isinstance(e, HandPrediction)] == [
        t.decided for t in messages
    ]
    assert not [e for e in events if isinstance(e, HandPinch)]  # it is not over yet
    events = (
        predictions.update((), Block(np.zeros((3000, 16), np.int16), 600), 0.0)
        + predictions.ended()
    )
    return [e for e in events if isinstance(e, HandPinch)]


def test_the_same_answers_are_said_to_be_the_same() -> None:
    (pinch,) = pinches(TOLD, (DONE,))
    assert pinch.final == changed(OF_HAND, host=0.0)  # the next is from samples of both
    assert isinstance(pinch.final, Estimate)
    assert pinch.check.same
    assert pinch.check.compared == 1


def test_a_difference_is_told() -> None:
    host_pinch = pinch_of(changed(ANSWER, high=39.25))
    (pinch,) = pinches(TOLD, (host_pinch,))
    assert not pinch.check.same


def test_a_one_sided_contact_is_reported() -> None:
    (alone,) = pinches((), (DONE,))
    assert (alone.contacts, alone.sample) == ((), 510)
    (alone,) = pinches(TOLD, ())
    assert not alone.check.same


def test_without_a_model_here_nothing_is_checked() -> None:
    (pinch,) = pinches(TOLD, (DONE,), checked=False)
    assert pinch.check is None


def test_a_pinch_in_a_gap_of_the_host_is_not_compared() -> None:
    predictions = HandPredictions("0123456789abcdef", RATE, checked=True)
    predictions.update((), Block(np.zeros((400, 16), np.int16), 0), 0.0)
    events = predictions.update(TOLD, Block(np.zeros((9000, 16), np.int16), 700), 0.0)
    (pinch,) = [e for e in events if isinstance(e, HandPinch)]
    assert pinch.check.lost


def test_predictions_without_a_pinch_are_discarded() -> None:
    """Predictions of a device that reports no first contact, or an old one, must not use memory."""
    predictions = HandPredictions("0123456789abcdef", RATE, checked=True)
    second = replace(TOLD[3], first=False)
    for k in range(100):
        block = Block(np.zeros((50, 16), np.int16), 10_000 + 50 * k)
        events = predictions.update((second, TOLD[1]), block, 0.0)
        assert sum(isinstance(e, HandPrediction) for e in events) == 2
    assert predictions._pinches == {}


def test_a_withdrawn_contact_leaves_no_pinch() -> None:
    withdrawn = DeviceContact(Finger.THUMB, 510, 575, True, 0, withdrawn=True)
    assert pinches((*TOLD[:2], withdrawn), ()) == []
    later = (DeviceContact(Finger.THUMB, 580, 590, True, 0),)
    (pinch,) = pinches((*TOLD[:2], withdrawn, *later), ())
    assert [c.sample for c in pinch.contacts] == [580]
    assert pinch.estimates == 0
