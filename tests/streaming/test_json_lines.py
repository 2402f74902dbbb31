"""JSON lines: each event as documented, without delay, even if the reader closes."""

import io
import json
import os
from dataclasses import replace
from typing import Any, TextIO, cast

from example_events import DESCRIPTOR, ESTIMATE, everything
from msgspec.structs import replace as changed

from firstcontact.cli.output import Output
from firstcontact.device import Health
from firstcontact.streaming import Sink, Update
from firstcontact.streaming._sinks import Fanout
from firstcontact.streaming.json_lines import JsonLinesSink


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
    assert [line["type"] for line in lines] == [
        "descriptor",
        "link",
        "failed",
        "marker",
        "closing_start",
        "contact",
        "estimate",
        "estimate",
        "no_estimate",
        "pinch",
        "object_estimate",
        "hand_command",
        "policy_command",
        "hand_prediction",
        "hand_prediction",
        "hand_pinch",
    ]
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
