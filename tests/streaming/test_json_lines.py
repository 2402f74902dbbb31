"""Lines of JSON: every event, as documented, at once, and a listener may go away."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from told_events import DESCRIPTOR, ESTIMATE, EVENTS, everything

from firstcontact.device import Health
from firstcontact.streaming import JsonLinesSink, PinchDone, Sink
from firstcontact.streaming._fanout import Fanout
from firstcontact.streaming._sink import Update

PAGE = Path(__file__).parents[2] / "docs/reference/live-output.md"


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


def documented() -> dict[str, list[str]]:
    """Fields of each type of line as the page's tables say, in order."""
    text = PAGE.read_text(encoding="utf-8").split("## JSON lines")[1].split("\n## ")[0]
    found = {}
    for section in text.split("\n### ")[1:]:
        rows = [line.split("|")[1] for line in section.splitlines() if line.startswith("| `")]
        found[section.split("\n")[0]] = [f for row in rows for f in re.findall(r"`(\w+)`", row)]
    return found


def test_every_type_of_line_has_the_documented_fields() -> None:
    lines = written(everything())
    pages = documented()
    assert {line["type"] for line in lines} == set(pages)
    for line in lines:
        assert list(line) == pages[line["type"]]
    (pinch,) = [line for line in lines if line["type"] == "pinch"]
    assert [list(c) for c in pinch["contacts"]] == [["finger", "sample", "decided"]] * 2
    assert [list(c) for c in pinch["strips"]] == [["finger", "sample"]] * 2
    assert [list(e) for e in pinch["estimates"]] == [pages["estimated"][1:]]
    (standing,) = [line for line in lines if line["type"] == "standing"]
    assert list(pinch["standing"]) == list(standing["answer"]) == pages["running"][1:]


def test_lines_say_what_happened_in_order() -> None:
    lines = written(everything())
    assert [line["type"] for line in lines] == [
        "descriptor",
        "link",
        "failed",
        "marker",
        "armed",
        "touched",
        "running",
        "standing",
        "estimated",
        "refused",
        "pinch",
        "same_object",
        "hand",
        "hand_contact",
        "hand_estimate",
        "hand_pinch",
    ]
    head, link, failed, marker, armed, touched, running, standing, *rest = lines
    estimated, refused, pinch, same, hand, found, own, whole = rest
    assert (found["decided"], own["value"], own["took_s"]) == (522, 30.5, 441e-6)
    assert (whole["check"]["same"], whole["check"]["largest"]) == (True, 0.002)
    assert (hand["told"], hand["by"]) == ("close", "keyboard")
    assert (running["value"], running["samples"], running["out_of_range"]) == (30.5, 59, False)
    assert (standing["answer"]["value"], standing["withdrawn"]) == (30.5, 1)
    assert (pinch["standing"]["value"], pinch["answers"]) == (30.5, 1)
    assert (pinch["available"]["value"], pinch["case"]) == (30.5, "in_time")
    assert (same["pinches"], same["value"], same["number"]) == (2, 30.5, 1)
    assert failed == {"type": "failed", "of": "page", "reason": "OSError: no"}
    assert (head["format"], head["format_version"]) == ("firstcontact-live", 2)
    assert head["hand"] == "linke Händ"
    assert head["rate_hz"] == DESCRIPTOR.layout.rate
    assert head["channels"][0] == {
        "name": "piezo_index",
        "kind": "piezo",
        "finger": "index",
        "unit": "V",
    }
    assert len(head["channels"]) == 16
    assert (link["connected"], link["lost_samples"], link["bad_frames"]) == (True, 7, 1)
    assert (marker["sample"], marker["text"]) == (1200, "Apfel ä")
    assert armed["sample"] == 400
    assert (touched["finger"], touched["sample"], touched["decided"]) == ("thumb", 510, 522)
    assert (touched["first"], touched["host_s"]) == (True, 1000.1)
    assert (estimated["low"], estimated["value"], estimated["high"]) == (25.0, 29.25, 33.5)
    assert (estimated["level"], estimated["window_s"]) == (0.9, 0.015)
    assert estimated["used"] is True
    assert refused["reason"] == "the window is not whole"
    assert pinch["strips"][1] == {"finger": "index", "sample": 578}
    assert pinch["estimates"][0]["compute_s"] == 0.0002


def test_late_is_told() -> None:
    (done,) = (event for event in EVENTS if isinstance(event, PinchDone))
    line = written(Update(events=(replace(done, answers=()),)))[-1]
    assert (line["case"], line["available"]) == ("too_late", None)


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


def test_a_number_that_json_does_not_have_is_told_as_a_failure_and_the_rest_goes_on() -> None:
    nan = replace(ESTIMATE, value=float("nan"))
    lines = written(Update(events=(EVENTS[0], nan, EVENTS[5]), health=Health(connected=True)))
    assert [line["type"] for line in lines] == ["descriptor", "armed", "failed", "refused"]
    assert lines[2]["of"] == "estimated"
    assert "JSON" in lines[2]["reason"]


def test_what_failed_elsewhere_is_told_once() -> None:
    fine, bad = Health(connected=True), {"page": "RuntimeError: no"}
    more = bad | {"lsl": "OSError: gone"}
    lines = written(*(Update(health=fine, failed=f) for f in ({}, bad, bad, more, more)))
    assert [(line["type"], line.get("of")) for line in lines[1:]] == [
        ("failed", "page"),
        ("failed", "lsl"),
    ]


def test_lines_come_through_a_pipe_at_once() -> None:
    """Nothing is closed or filled: a flushed line alone is what lets the reader go on."""
    reading, writing = os.pipe()
    with os.fdopen(reading, encoding="utf-8") as reader, os.fdopen(writing, "w") as writer:
        sink = JsonLinesSink(writer)
        sink.open(DESCRIPTOR)
        assert json.loads(reader.readline())["type"] == "descriptor"
        sink.take(Update(events=EVENTS[:1], health=Health(connected=True)))
        assert json.loads(reader.readline())["type"] == "armed"


def test_a_listener_that_goes_away_ends_the_sink_alone() -> None:
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w") as writer:
        fanout = Fanout([JsonLinesSink(writer)], DESCRIPTOR)
        fanout.put(everything())
        fanout.close(60.0)
        assert fanout.deserted
        assert fanout.failed == fanout.dropped == {}, "who goes away has had enough"


def test_a_program_whose_listener_went_away_ends_without_a_word() -> None:
    code = (
        "import sys\n"
        f"sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "from told_events import DESCRIPTOR, everything\n"
        "from firstcontact.streaming._json_lines import JsonLinesSink\n"
        "sink = JsonLinesSink(sys.stdout)\n"
        "sys.stdin.readline()\n"
        "try:\n"
        "    sink.open(DESCRIPTOR)\n"
        "except BrokenPipeError:\n"
        "    sys.exit(0)\n"
        "sys.exit(3)\n"
    )
    program = subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert program.stdout is not None
    program.stdout.close()
    program.stdout = None
    _, said = program.communicate(b"\n", timeout=120)
    assert (program.returncode, said) == (0, b"")
