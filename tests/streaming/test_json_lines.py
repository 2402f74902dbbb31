"""Text outputs: JSON lines, and text for users."""

import io
import json
import os
from dataclasses import replace
from typing import Any, TextIO, cast

from example_events import ANSWER, DESCRIPTOR, ESTIMATE, EVENTS, everything, timed
from example_events import pinch as pinch_of
from msgspec.structs import replace as changed
from page_feed import Feed

from firstcontact.cli.output import Output
from firstcontact.core import Label
from firstcontact.device import Health
from firstcontact.device.twin_words import peak_text
from firstcontact.recording import Marker, PinchMark
from firstcontact.streaming import PinchDone, Sink, Update
from firstcontact.streaming._sinks import Fanout
from firstcontact.streaming.json_lines import JsonLinesSink
from firstcontact.streaming.text import TextSink, pinch_line


def written(*updates: Update) -> list[dict[str, Any]]:
    stream = io.StringIO()
    sink: Sink = JsonLinesSink(stream)
    sink.open(DESCRIPTOR)
    for update in updates:
        sink.take(update)
    sink.close()
    text = stream.getvalue()
    assert text.endswith("\n")
    return [json.loads(line) for line in text.splitlines()]


def test_lines_say_what_happened_in_order() -> None:
    lines = written(everything())
    types = (
        "descriptor link failed marker closing_start contact estimate estimate no_estimate pinch "
        "object_estimate hand_command policy_command hand_prediction hand_prediction hand_pinch"
    )
    assert [line["type"] for line in lines] == types.split()
    _, link, failed, marker, _, _, estimate, final, _, finished, *remainder = lines
    combined, hand, command, computed, own_values, complete = remainder
    assert computed["event"]["contact"]["decided"] == 522
    assert (own_values["event"]["value"], own_values["event"]["compute"]) == (30.5, 441e-6)
    assert (complete["check"]["same"], complete["check"]["compared"]) == (True, 1)
    assert (hand["ask"], hand["by"]) == ("close", "keyboard")
    assert (command["speed"], command["force"]) == (0.02, 1.5)
    assert estimate["contact"] == {"finger": 1, "sample": 510, "decided": 522}
    assert (estimate["in_time"], final["in_time"], final["final"]) == (None, True, True)
    assert (finished["estimates"][0]["in_time"], finished["verdict"]) == (True, "in_time")
    assert (combined["pinches"], combined["value"], combined["number"]) == (2, 30.5, 1)
    assert failed == {"type": "failed", "subject": "page", "reason": "OSError: no"}
    assert (link["connected"], link["lost_samples"], link["bad_frames"]) == (True, 7, 1)
    assert (marker["sample"], marker["text"]) == (1200, "Apfel ä")


def test_the_link_is_told_only_when_it_changes() -> None:
    calm = Health(connected=True, samples=10)
    lines = written(
        Update(health=calm),
        Update(health=replace(calm, samples=20, host_rate=4936.0)),
        Update(health=replace(calm, lost_samples=3)),
        Update(health=replace(calm, lost_samples=3, samples=99)),
        Update(health=replace(calm, lost_samples=3, connected=False)),
    )
    assert [(line["type"], line.get("connected")) for line in lines[1:]] == [
        ("link", True),
        ("link", False),
    ]


def test_a_number_that_json_does_not_have_is_null() -> None:
    for value in (float("nan"), float("inf")):
        odd = changed(ESTIMATE, value=value)
        lines = written(Update(events=(odd,), health=Health(connected=True)))
        assert [line["type"] for line in lines] == ["descriptor", "estimate"]
        assert lines[1]["value"] is None


def test_a_listener_that_goes_away_ends_the_sink_alone() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as writer:
        out = cast(TextIO, Output(writer, raises=True))
        fanout = Fanout([JsonLinesSink(out)], DESCRIPTOR)
        fanout.put(everything())
        fanout.close(60.0)
        assert fanout.deserted
        assert fanout.failed == fanout.dropped == {}, "who goes away has had enough"


def test_pinches_losses_and_failures_are_a_line_each() -> None:
    stream = io.StringIO()
    sink = TextSink(stream)
    sink.open(DESCRIPTOR)
    sink.take(everything())
    sink.take(Update(health=Health(True, lost_samples=7)))
    sink.close()
    _, lost, failed, pinch, same, hand, own_values = stream.getvalue().splitlines()
    assert "7" in lost
    assert "OSError: no" in failed
    for part in ("30.5 Shore A (22 to 39)", "in time", "14.2 ms", "Apfel ä"):
        assert part in pinch
    assert "30.5" in same
    assert "keyboard" in hand
    assert "0123456789abcdef" in own_values


def test_an_estimate_that_came_after_the_second_contact_is_a_detail() -> None:
    late = timed(ANSWER, value=40.0, waited=0.01)
    line = pinch_line(pinch_of(ANSWER, late))
    assert "30.5 Shore A (22 to 39)" in line
    assert "from 12 ms at 12.1 ms, in time, 40.0 Shore A (22 to 39)" in line
    assert "from 12 ms at 22.1 ms, too late" in line
    assert line.index("30.5") < line.index("40.0")
    assert "no estimate in time" in pinch_line(pinch_of(late))


def named(*markers: Marker, marks: tuple[PinchMark, ...] = ()) -> list[str]:
    """Return labels and markers around a pinch from sample 400 to 1600."""
    stream = io.StringIO()
    sink = TextSink(stream, {"block 29": 29.0}.get)
    sink.open(DESCRIPTOR)
    (arrival,) = Feed().update().arrivals
    (finished_pinch,) = (event for event in EVENTS if isinstance(event, PinchDone))
    words = replace(arrival, markers=markers, pinches=marks)
    sink.take(Update(arrivals=(words,), events=(finished_pinch,), health=Health(True)))
    return stream.getvalue().splitlines()[1:]


def test_a_pinch_names_the_object_of_the_twin() -> None:
    (line,) = named(Marker(450, "twin: block 29"), Marker(500, peak_text(3.0)))
    assert line.endswith(", twin: block 29, 29 Shore A")
    (line,) = named(Marker(450, "twin: pear"))
    assert line.endswith(", twin: pear")
    (line,) = named(Marker(1600, "twin: block 29"))
    assert "block" not in line, "that is the next pinch"


def test_a_pinch_says_what_a_marker_or_a_label_named() -> None:
    (line,) = named(Marker(100, "my apple"))
    assert line.endswith(', marked "my apple"')
    mark = PinchMark(0, 300, 1500, 0, Label("pear", 40.0))
    (line,) = named(marks=(mark,))
    assert line.endswith(", labelled pear, 40 Shore A")
    (line,) = named(marks=(replace(mark, epoch=1),))
    assert "pear" not in line
