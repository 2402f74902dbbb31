"""One event of each kind, with functions that make estimates and pinches."""

import json
from typing import Any

import numpy as np
from msgspec.structs import replace

from firstcontact.core import Block, Contact, Finger, fingertip_layout
from firstcontact.device import Arrival, Descriptor, Health
from firstcontact.device.descriptor import DeviceContact, DeviceEstimate
from firstcontact.recording import Marker
from firstcontact.streaming import (
    ClosingStart,
    ContactEvent,
    Event,
    HandCheck,
    HandCommand,
    HandPinch,
    HandPrediction,
    NoEstimate,
    ObjectEstimate,
    PinchDone,
    PolicyCommand,
    Update,
)
from firstcontact.streaming.events import Ask, Estimate
from firstcontact.streaming.page.state import State
from firstcontact.testing import make_estimate

DESCRIPTOR = Descriptor(fingertip_layout(), "fw 1", "piezo", "linke Händ", "twin")
RATE = DESCRIPTOR.layout.rate
FIRST = Contact(Finger.THUMB, 510, 522)
SECOND = Contact(Finger.INDEX, 580, 590)
START = ClosingStart(400, 0)
FIRST_EVENT = ContactEvent(FIRST, True, 0, 1000.1)
SECOND_EVENT = ContactEvent(SECOND, False, 0, 1000.12)


def timed(estimate: Estimate, **fields: Any) -> Estimate:
    """Return the estimate with changed fields, and ``available`` computed from them."""
    e = replace(estimate, **fields)
    ready = (e.complete - e.contact.sample) / RATE
    return replace(e, available=ready + e.waited + e.transport + e.compute)


def pinch(
    *estimates: Estimate, contacts: tuple[Contact, ...] = (FIRST, SECOND), **fields: Any
) -> PinchDone:
    """Return a pinch with these estimates, the last one final."""
    if estimates:
        estimates = (*estimates[:-1], replace(estimates[-1], final=True))
    offset = (contacts[1].sample - contacts[0].sample) / RATE if len(contacts) > 1 else None
    places = {"number": 1, "start": 400, "end": 1600, "epoch": 0} | fields
    return PinchDone(contacts=contacts, offset=offset, estimates=estimates, **places)


#: An estimate of a window model, with an interval.
ESTIMATE = timed(
    make_estimate(29.25, 25.0, 33.5, 0.015), model="svm", contact=FIRST, complete=586,
    host=1000.125, compute=0.0002,
)  # fmt: skip
#: An estimate of the network.
ANSWER = timed(
    ESTIMATE, value=30.5, low=22.0, high=39.0, half_width=8.5, elapsed=59 / RATE, model="network",
    complete=568, host=1000.12, compute=0.0003,
)  # fmt: skip
FINAL = replace(ANSWER, final=True, in_time=True)
MESSAGES = (
    DeviceContact(Finger.THUMB, 510, 522, True, 0),
    DeviceEstimate(Finger.THUMB, 510, 59, 568, 30.5, 22.0, 39.0, False, False, 441e-6, 0),
)
MODEL = "0123456789abcdef"
OF_HAND = timed(
    replace(ANSWER, model=MODEL, level=0.0, half_width=None, compute=441e-6, host=1000.12)
)
DONE = pinch(ANSWER, strips=(Contact(Finger.THUMB, 509, 509), Contact(Finger.INDEX, 578, 578)))
EVENTS: tuple[Event, ...] = (
    START,
    FIRST_EVENT,
    ANSWER,
    FINAL,
    NoEstimate(FIRST, "the window is not whole", 586, 0),
    DONE,
    ObjectEstimate(
        number=1, value=30.5, low=22.0, high=39.0, level=0.9, pinches=2, end=1600, epoch=0
    ),
    HandCommand(Ask.CLOSE, "keyboard", 390, 0),
    PolicyCommand(0.02, 1.5, 395, 0),
    HandPrediction(FIRST_EVENT),
    HandPrediction(OF_HAND),
    HandPinch(
        number=1,
        model=MODEL,
        contacts=(FIRST,),
        final=OF_HAND,
        estimates=1,
        check=HandCheck(same=True, compared=1),
        sample=510,
        epoch=0,
    ),
)


def numbered(first: int, n: int, epoch: int = 0, host: float = 0.0) -> Arrival:
    """Return samples whose first channel holds their number. The other columns are zero."""
    data = np.zeros((n, 16), dtype=np.int16)
    data[:, 0] = np.arange(first, first + n) % 32768
    return Arrival(Block(data, first, epoch), host)


def everything() -> Update:
    """Return an update with all events, a marker and a lossy link."""
    arrival = Arrival(numbered(0, 1600).block, 1000.0, markers=(Marker(1200, "Apfel ä", 0),))
    health = Health(connected=True, samples=1600, lost_samples=7, lost_frames=2, bad_frames=1)
    return Update((arrival,), EVENTS, health, failed={"page": "OSError: no"})


def page_state(*events: Event) -> dict[str, Any]:
    """Return the state of the page after these events, as a viewer receives it."""
    state = State(DESCRIPTOR, {}, controls=None)
    state.take(Update((numbered(0, 1600),), events, Health(connected=True)))
    return {name: json.loads(part) for name, part in state.changed({}).items()}
