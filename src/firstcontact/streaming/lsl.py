"""Output of samples and events as streams of the Lab Streaming Layer (LSL)."""

from __future__ import annotations

import socket
import time
from typing import Any

import numpy as np

from firstcontact.core import finger_name
from firstcontact.core.installation import require_modules
from firstcontact.device import Arrival, Descriptor
from firstcontact.device.clock import DeviceClock
from firstcontact.device.lsl_source import lsl_library
from firstcontact.streaming._sinks import Update
from firstcontact.streaming.json_lines import FailedLine, json_line, marker_line
from firstcontact.streaming.outputs import OutputKind

require_modules("live", "pylsl")

#: Length of the buffer for a slow listener, s.
BUFFERED = 60


class LslSink:
    """Output to two LSL streams: samples in physical units, and events as JSON markers."""

    name = "lsl"
    every = 0.02
    is_prompt = True

    def __init__(self, name: str = "firstcontact") -> None:
        self._lsl: Any = lsl_library()
        self._name = name
        self._samples: Any = None
        self._events: Any = None
        self._newest = -np.inf  # time stamp of the newest event

    def open(self, descriptor: Descriptor) -> None:
        layout = descriptor.layout
        self._layout = layout
        self._columns = tuple(range(layout.width))
        self._clock = DeviceClock(layout.rate)
        # Both clocks of this machine count seconds, but they may begin at different times.
        self.shift = self._lsl.local_clock() - time.monotonic()
        samples = self._info(
            "samples", "Tactile", layout.width, layout.rate, self._lsl.cf_float32, descriptor
        )
        channels = samples.desc().append_child("channels")
        for name, c in zip(layout.column_names, layout.column_channels, strict=True):
            channel = channels.append_child("channel")
            channel.append_child_value("label", name)
            channel.append_child_value("type", c.sensor or c.kind.value)
            channel.append_child_value("unit", c.unit)
            channel.append_child_value("finger", finger_name(c.finger))
        irregular, text = self._lsl.IRREGULAR_RATE, self._lsl.cf_string
        events = self._info("events", "Markers", 1, irregular, text, descriptor)
        self._samples = self._lsl.StreamOutlet(samples, max_buffered=BUFFERED)
        self._events = self._lsl.StreamOutlet(events, max_buffered=BUFFERED)

    def take(self, update: Update) -> None:
        for arrival in update.arrivals:
            self._send(arrival)
        for name, reason in update.failed.items():
            at = self._newest if np.isfinite(self._newest) else self._lsl.local_clock()
            self._events.push_sample([json_line(FailedLine(name, reason))], at)
        for event in update.events:
            self._push(json_line(event), self._clock.host_time(event.known_sample, event.epoch))

    def close(self) -> None:
        """Remove both streams from the network. A second call does nothing."""
        self._samples = self._events = None

    def _send(self, arrival: Arrival) -> None:
        block = arrival.block
        if len(block.data):
            stamps = self._clock.stamps(block, arrival.host) + self.shift
            values = self._layout.physical(block.data, self._columns)
            self._samples.push_chunk(values.astype(np.float32), stamps.tolist())
        for marker in arrival.markers:
            at = self._clock.host_time(marker.sample, marker.epoch)
            self._push(marker_line(marker), at)

    def _push(self, text: str, host: float) -> None:
        self._newest = max(self._newest, host + self.shift)
        self._events.push_sample([text], self._newest)

    def _info(
        self, kind: str, content: str, width: int, rate: float, form: Any, descriptor: Descriptor
    ) -> Any:
        identity = f"{self._name}@{socket.gethostname()} {kind}"
        info = self._lsl.StreamInfo(f"{self._name} {kind}", content, width, rate, form, identity)
        acquisition = info.desc().append_child("acquisition")
        for field in ("firmware", "sensor", "hand", "source"):
            acquisition.append_child_value(field, getattr(descriptor, field))
        return info


LSL = OutputKind("lsl", lambda session, options: LslSink())
