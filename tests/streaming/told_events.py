"""One of each thing that the live part tells, for the tests of the sinks."""

from __future__ import annotations

import numpy as np

from firstcontact.core import Block, Contact, Finger, fingertip_layout
from firstcontact.device import Arrival, Descriptor, DeviceContact, DeviceEstimate, Health
from firstcontact.recording import Marker
from firstcontact.streaming import (
    Armed,
    Ask,
    Estimated,
    PinchDone,
    Refused,
    Running,
    Settled,
    Touched,
)
from firstcontact.streaming._events import (
    Event,
    FromHand,
    HandAsked,
    HandCheck,
    HandPinch,
    SameObject,
)
from firstcontact.streaming._sink import Update

DESCRIPTOR = Descriptor(fingertip_layout(), "fw 1", "piezo", "linke Händ", "twin")
FIRST = Contact(Finger.THUMB, 510, 522)
SECOND = Contact(Finger.INDEX, 580, 590)
ESTIMATE = Estimated(
    contact=FIRST,
    value=29.25,
    low=25.0,
    high=33.5,
    level=0.9,
    duration=0.015,
    complete=586,
    epoch=0,
    used=True,
    host=1000.125,
    compute=0.0002,
)
ANSWER = Running(
    contact=FIRST,
    value=30.5,
    low=22.0,
    high=39.0,
    level=0.9,
    half_width=8.5,
    strange=False,
    samples=59,
    duration=59 / 4936,
    complete=568,
    epoch=0,
    host=1000.12,
    compute=0.0003,
)
TOLD = (
    DeviceContact(Finger.THUMB, 510, 522, True, 0),
    DeviceEstimate(Finger.THUMB, 510, 59, 568, 30.5, 22.0, 39.0, False, False, 441e-6, 0),
)
EVENTS: tuple[Event, ...] = (
    Armed(400, 0),
    Touched(FIRST, first=True, epoch=0, host=1000.1),
    ANSWER,
    Settled(FIRST, ANSWER, withdrawn=1, complete=590, epoch=0),
    ESTIMATE,
    Refused(FIRST, "the window is not whole", 0),
    PinchDone(
        number=1,
        armed=400,
        end=1600,
        epoch=0,
        contacts=(FIRST, SECOND),
        strips=((Finger.THUMB, 509), (Finger.INDEX, 578)),
        estimates=(ESTIMATE,),
        rate=DESCRIPTOR.layout.rate,
        answers=(ANSWER,),
    ),
    SameObject(1, 30.5, 22.0, 39.0, 0.9, 2, end=1600, epoch=0),
    HandAsked(Ask.CLOSE, "keyboard", 390, 0),
    FromHand(TOLD[0], 1000.1),
    FromHand(TOLD[1], 1000.12),
    HandPinch(
        number=1,
        model="0123456789abcdef",
        first=TOLD[0],
        second=None,
        standing=TOLD[1],
        answers=1,
        check=HandCheck(contacts=True, compared=1, largest=0.002, flags=True, missing=0),
        sample=510,
        epoch=0,
    ),
)


def numbered(first: int, n: int, epoch: int = 0, host: float = 0.0) -> Arrival:
    """Samples whose first channel is their number, and the other columns zero."""
    data = np.zeros((n, 16), dtype=np.int16)
    data[:, 0] = np.arange(first, first + n) % 32768
    return Arrival(Block(data, first, epoch), host)


def everything() -> Update:
    """All events, a marker and a link that lost something."""
    arrival = Arrival(numbered(0, 1600).block, 1000.0, markers=(Marker(1200, "Apfel ä", 0),))
    health = Health(connected=True, samples=1600, lost_samples=7, lost_frames=2, bad_frames=1)
    return Update((arrival,), EVENTS, health, failed={"page": "OSError: no"})
