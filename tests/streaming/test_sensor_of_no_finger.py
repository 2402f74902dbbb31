"""Contacts on a sensor that belongs to no finger."""

import json
from io import StringIO

from example_events import pinch

from firstcontact.core import Block, Channel, ChannelKind, Contact, Layout, VibrationSensor
from firstcontact.device import Arrival, Descriptor, Health
from firstcontact.streaming import ContactEvent, Update
from firstcontact.streaming.json_lines import JsonLinesSink
from firstcontact.streaming.page.state import State
from firstcontact.streaming.text import pinch_line
from firstcontact.testing.synthetic import closing

MICROPHONE = Channel(
    "microphone", ChannelKind.VIBRATION, None, "Pa", sensor=VibrationSensor.MICROPHONE
)
LAYOUT = Layout((MICROPHONE,), 4936.0)
CONTACT = Contact(None, 100, 110)
TOUCHED = ContactEvent(CONTACT, True, 0, 0.0)
DONE = pinch(contacts=(CONTACT,), number=0, start=0, end=400)


def test_in_json_and_in_words() -> None:
    stream = StringIO()
    sink = JsonLinesSink(stream)
    sink.open(Descriptor(LAYOUT))
    sink.take(Update(events=(TOUCHED,)))
    lines = [json.loads(line) for line in stream.getvalue().splitlines()]
    descriptor, touched = (
        next(x for x in lines if x["type"] == t) for t in ("descriptor", "contact")
    )
    (channel,) = descriptor["channels"]
    assert channel == {"name": "microphone", "kind": "microphone", "finger": None, "unit": "Pa"}
    assert touched["contact"]["finger"] is None
    assert "sensor" in pinch_line(DONE)


def test_on_the_page() -> None:
    state = State(Descriptor(LAYOUT), {}, controls=None)
    assert json.loads(state.hello)["fingers"] == [2]  # the third of its names and colours
    block = Block(closing(1).data[:400, :1], 0)
    state.take(Update((Arrival(block, 0.0),), (TOUCHED, DONE), health=Health()))
    assert json.loads(state.changed({})["pinches"])[0]["pinch"]["contacts"][0]["finger"] is None
