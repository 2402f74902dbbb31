"""The output for Foxglove, read by a client of its own as ``foxglove.sdk.v1`` describes it."""

import json
import re
import struct
import subprocess
import sys
from collections import defaultdict
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from example_events import DESCRIPTOR, EVENTS, everything
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from firstcontact.core import InputError
from firstcontact.streaming import Event
from firstcontact.streaming.json_lines import FailedLine, json_line, marker_line

foxglove = pytest.importorskip("foxglove")
from firstcontact.streaming.foxglove import FoxgloveSink  # noqa: E402

LAYOUTS = Path(__file__).parents[2] / "examples" / "foxglove"
#: Longest wait for a message, s.
PATIENCE = 30.0
#: Head of a message: operation 1, subscription, and time in ns since 1970.
HEAD = struct.Struct("<BIQ")
COLUMNS = DESCRIPTOR.layout.width
#: CDR's head, the sample's number and epoch, and its values.
SAMPLE = struct.Struct(f"<4xQI{COLUMNS}f")

PROGRAM = "from firstcontact.cli.main import main; raise SystemExit(main())"


class Viewer:
    """Client that subscribes to all topics."""

    def __init__(self, url: str) -> None:
        protocol = Subprotocol("foxglove.sdk.v1")
        self._stack = ExitStack()
        self._socket = self._stack.enter_context(
            connect(url, subprotocols=[protocol], compression=None)
        )
        assert self._socket.subprotocol == protocol
        self.info = json.loads(self._socket.recv(PATIENCE))
        self.channels: dict[str, dict[str, Any]] = {}
        self.messages: dict[str, list[tuple[int, bytes]]] = defaultdict(list)

    def subscribe(self, topics: int) -> None:
        """Subscribe to every topic once so many are offered."""
        while len(self.channels) < topics:
            offer = json.loads(self._socket.recv(PATIENCE))
            assert offer["op"] == "advertise"
            self.channels |= {channel["topic"]: channel for channel in offer["channels"]}
        wanted = [{"id": c["id"], "channelId": c["id"]} for c in self.channels.values()]
        self._socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))

    def read(self, messages: float = np.inf) -> None:
        """Read so many messages, or all until the server ends the connection."""
        topics = {channel["id"]: topic for topic, channel in self.channels.items()}
        while messages > 0:
            try:
                message = self._socket.recv(PATIENCE)
            except ConnectionClosed:
                return
            if isinstance(message, bytes):
                operation, subscription, time = HEAD.unpack_from(message)
                assert operation == 1
                self.messages[topics[subscription]].append((time, message[HEAD.size :]))
                messages -= 1

    def lines(self, topic: str) -> list[str]:
        return [data.decode() for _, data in self.messages[topic]]

    def close(self) -> None:
        self._stack.close()


def test_a_viewer_gets_every_sample_grid_and_event() -> None:
    update = everything()
    layout = DESCRIPTOR.layout
    sink = FoxgloveSink("127.0.0.1:0")
    try:
        assert sink.url.startswith("ws://127.0.0.1:")
        with pytest.raises(InputError, match="free port"):
            FoxgloveSink(sink.url.removeprefix("ws://"))
        viewer = Viewer(sink.url)
        sink.open(DESCRIPTOR)
        viewer.subscribe(len(sink.events) + 3)
        while not all(c.has_sinks() for c in [sink.samples, *sink.events.values()]):
            pass
        sink.take(update)
        samples = len(update.arrivals[0].block.data)
        viewer.read(samples + 2 + len(EVENTS) + 2)
        viewer.close()
    finally:
        sink.close()
        sink.close()
    assert viewer.info["capabilities"] == []  # viewers cannot send anything
    text = viewer.channels["/samples"]["schema"]
    assert re.findall(r"float32 (\w+)", text) == list(layout.column_names)
    times = np.array([time for time, _ in viewer.messages["/samples"]])
    rows = np.array([SAMPLE.unpack(data) for _, data in viewer.messages["/samples"]])
    np.testing.assert_array_equal(rows[:, 0], np.arange(samples))
    physical = layout.physical(update.arrivals[0].block.data, tuple(range(layout.width)))
    np.testing.assert_array_equal(rows[:, 2:], physical.astype(np.float32))
    np.testing.assert_allclose(np.diff(times) / 1e9, 1 / layout.rate, atol=1e-6)
    for finger in ("index", "thumb"):
        assert viewer.channels[f"/force/{finger}"]["schemaName"] == "foxglove.Grid"
        assert len(viewer.messages[f"/force/{finger}"]) == 1
    for event in EVENTS:
        tag = event.__struct_config__.tag
        assert json_line(event) in viewer.lines(f"/{tag}")
    assert viewer.lines("/marker") == [marker_line(update.arrivals[0].markers[0])]
    assert viewer.lines("/failed") == [json_line(FailedLine("page", "OSError: no"))]
    # The schema names each field that a line has, so that a viewer can plot it.
    for topic, channel in viewer.channels.items():
        for line in viewer.lines(topic) if channel["encoding"] == "json" else ():
            fields = set(json.loads(channel["schema"])["properties"])
            assert set(json.loads(line)) - {"type"} <= fields


@pytest.mark.parametrize("name", ["1st sensor", "sample", "piezo_INDEX"])
def test_names_that_ros_refuses_are_replaced(name: str) -> None:
    first, second, *others = DESCRIPTOR.layout.channels
    channels = (first, replace(second, name=name), *others)
    sink = FoxgloveSink("127.0.0.1:0")
    sink.open(replace(DESCRIPTOR, layout=replace(DESCRIPTOR.layout, channels=channels)))
    sink.close()
    text = sink.samples.schema().data.decode()
    assert re.findall(r"float32 (\w+)\n?", text) == [f"column_{k}" for k in range(COLUMNS)]


def follow(seconds: float) -> Viewer:
    """Return a viewer of the live twin with all that it got."""
    words = ["live", "--device", "twin", "--json", "--seconds", str(seconds)]
    words += ["--foxglove", "--foxglove-address", "127.0.0.1:0"]
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        url = next(line.split()[-1] for line in process.stderr if line.startswith("foxglove: "))
        viewer = Viewer(url)
        viewer.subscribe(len(get_args(Event)) + 5)  # with samples, grids, markers and failures
        viewer.read()
        viewer.close()
        text = process.stderr.read()
    assert process.returncode == 0, text
    assert "foxglove" not in text, text  # no updates were dropped
    return viewer


def lost(viewer: Viewer, seconds: float) -> int:
    """Return the number of missing samples, from the first to the last that came."""
    numbers = [SAMPLE.unpack(data)[0] for _, data in viewer.messages["/samples"]]
    assert numbers == sorted(numbers)
    assert len(numbers) > 0.3 * seconds * DESCRIPTOR.layout.rate  # a busy viewer comes late
    return int(numbers[-1] - numbers[0] + 1 - len(numbers))


def test_no_sample_of_the_live_twin_is_lost() -> None:
    viewer = follow(5)
    assert lost(viewer, 5) == 0
    for topic in ("/contact", "/estimate", "/force/index"):
        assert viewer.messages[topic], topic


def named(layout: str) -> set[str]:
    """Return the message paths in a layout file, and check that it shows each of its panels."""
    tree = json.loads((LAYOUTS / f"{layout}.json").read_text(encoding="utf-8"))
    text = json.dumps(tree["layout"])
    assert {p for p in tree["configById"] if f'"{p}"' in text} == set(tree["configById"])
    return set(re.findall(r'"(/[^"]+)"', json.dumps(tree["configById"])))


def test_the_layouts_name_what_exists() -> None:
    sink = FoxgloveSink("127.0.0.1:0")
    sink.open(DESCRIPTOR)
    sink.close()
    fields = {f"/samples.{name}" for name in DESCRIPTOR.layout.column_names}
    fields |= {f"/{topic}" for topic in sink.events} | {"/force/index", "/force/thumb"}
    for topic, channel in sink.events.items():
        properties = json.loads(channel.schema().data)["properties"]
        fields |= {f"/{topic}.{name}" for name in properties}
        inner = properties.get("contact", {}).get("properties", {})
        fields |= {f"/{topic}.contact.{name}" for name in inner}
    assert named("live") <= fields
    layout = DESCRIPTOR.layout
    pairs = zip(layout.column_names, layout.column_channels, strict=True)
    exported = {f"/{channel.kind}/{name}.data" for name, channel in pairs}
    assert named("recording") <= exported | {"/contacts.data"}
