"""LSL streams as received by another process over the loopback interface."""

import json
import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from example_events import DESCRIPTOR, EVENTS, everything, numbered

from firstcontact.core import VibrationSensor
from firstcontact.device import Arrival
from firstcontact.streaming import Update
from firstcontact.streaming.json_lines import FailedLine, json_line, marker_line
from firstcontact.streaming.lsl import LslSink

pylsl = pytest.importorskip("pylsl")

#: Longest wait for a stream to be found and for what it carries, s.
PATIENCE = 30.0
LOOPBACK = (
    "[multicast]\nResolveScope = machine\n[lab]\nKnownPeers = {127.0.0.1}\n[log]\nlevel = -3\n"
)
#: Runs apart, says "open" when it listens, and prints what it got until a stream is whole.
LISTENER = """
import json, sys, pylsl
name, patience = sys.argv[1], float(sys.argv[4])
samples, events = int(sys.argv[2]), int(sys.argv[3])
inlets = []
for kind in ("samples", "events"):
    found = pylsl.resolve_byprop("name", f"{name} {kind}", 1, patience)
    if not found:
        sys.exit(77)
    inlets.append(pylsl.StreamInlet(found[0]))
    inlets[-1].open_stream(patience)
info = inlets[0].info(patience)
print("open", flush=True)
got = {"xml": info.as_xml(), "type": info.type(), "rate": info.nominal_srate(),
       "events_type": inlets[1].info(patience).type()}
rows, times = [], []
while len(rows) < samples:
    row, time = inlets[0].pull_sample(patience)
    if row is None:
        break
    rows.append(row)
    times.append(time)
texts, told = [], []
while len(texts) < events:
    text, time = inlets[1].pull_sample(patience)
    if text is None:
        break
    texts.append(text[0])
    told.append(time)
got |= {"rows": rows, "times": times, "texts": texts, "told": told, "clock": pylsl.local_clock()}
print(json.dumps(got), flush=True)
"""


@pytest.fixture(scope="module")
def loopback(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep the streams on this machine. LSL reads this setting once, at its first use."""
    config = tmp_path_factory.mktemp("lsl") / "lsl_api.cfg"
    config.write_text(LOOPBACK, encoding="utf-8")
    previous = os.environ.get("LSLAPICFG")
    os.environ["LSLAPICFG"] = str(config)
    yield
    if previous is None:
        del os.environ["LSLAPICFG"]
    else:
        os.environ["LSLAPICFG"] = previous


class Listener:
    """Process that finds both streams, and the data that it received."""

    def __init__(self, name: str, samples: int, events: int) -> None:
        arguments = [name, str(samples), str(events), str(PATIENCE)]
        self._process = subprocess.Popen(
            [sys.executable, "-c", LISTENER, *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._first = self._process.stdout.readline()

    def require(self) -> None:
        """Skip the test if LSL finds no stream because of the machine's network interfaces."""
        if self._first != "open\n":
            _, errors = self._process.communicate(timeout=2 * PATIENCE)
            if self._process.returncode == 77:
                pytest.skip("LSL cannot discover streams on any network interface here")
            raise AssertionError(errors)

    def result(self) -> Any:
        """Return the received samples once the stream is complete."""
        out, errors = self._process.communicate(timeout=4 * PATIENCE)
        assert self._process.returncode == 0, errors
        return json.loads(out)


def test_a_listener_gets_every_sample_and_event(loopback: None) -> None:
    name = f"fc-test-{socket.gethostname()}-{os.getpid()}"
    marker = everything().arrivals[0].markers[0]
    sink = LslSink(name)
    assert sink.name == "lsl"
    sink.open(DESCRIPTOR)
    try:
        listener = Listener(name, samples=1710, events=len(EVENTS) + 2)
        listener.require()
        now = pylsl.local_clock() - sink.shift
        blocks = [numbered(k, 10, host=now + (k + 9) / 4936) for k in range(0, 110, 10)]
        for block in blocks:
            sink.take(Update((block,)))
        sink.take(Update((numbered(110, 1600, host=now + 1709 / 4936),)))
        sink.take(Update((Arrival(numbered(1710, 0).block, now, (marker,)),), EVENTS))
        sink.take(Update(failed={"page": "OSError: no"}))
        got = listener.result()
    finally:
        sink.close()

    layout = DESCRIPTOR.layout
    rows = np.array(got["rows"])
    assert rows.shape == (1710, 16)
    # The number of a sample is its first raw value: nothing is lost, doubled or moved.
    raw = rows[:, 0] / layout.channels[0].scale + layout.channels[0].offset
    np.testing.assert_array_equal(np.rint(raw), np.arange(1710))
    np.testing.assert_array_equal(rows[:, 2:], 0.0)
    times = np.array(got["times"])
    np.testing.assert_allclose(np.diff(times), 1 / layout.rate, atol=1e-6)
    # The first sample came now, on this clock that both processes share.
    shift = sink.shift
    assert times[0] == pytest.approx(now + shift, abs=1e-3)

    texts = [
        marker_line(marker),
        *(json_line(e) for e in EVENTS),
    ]
    assert got["texts"] == [*texts, json_line(FailedLine("page", "OSError: no"))]
    stamps = np.array(got["told"])
    assert (np.diff(stamps) >= 0).all()
    # The pinch is known with its last sample; nothing before the marker goes back behind it.
    assert stamps[0] == pytest.approx(times[1200], abs=1e-6)
    assert stamps[-1] == pytest.approx(times[1599], abs=1e-6)

    assert (got["type"], got["events_type"]) == ("Tactile", "Markers")
    assert got["rate"] == layout.rate
    described = ElementTree.fromstring(got["xml"]).find("desc")
    channels = [{e.tag: e.text or "" for e in c} for c in described.findall("channels/channel")]
    assert channels == [
        {
            "label": c.name,
            "type": c.sensor or c.kind.value,
            "unit": c.unit,
            "finger": c.finger.name.lower(),
        }
        for c in layout.channels
    ]
    assert sum(c["type"] == VibrationSensor.PIEZO for c in channels) == 2
    assert described.findtext("acquisition/hand") == "linke Händ"
