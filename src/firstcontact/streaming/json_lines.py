"""Output of JSON lines for other programs: one object per line, whose field states its type."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import fields
from typing import TextIO, get_type_hints

import msgspec

from firstcontact.core import Finger, finger_name
from firstcontact.device import Descriptor, Health
from firstcontact.device.descriptor import DevicePredictor
from firstcontact.recording import Marker
from firstcontact.streaming._sinks import Update
from firstcontact.streaming.outputs import OutputKind

FORMAT = "firstcontact-live"
#: Version of the format, raised when a field changes its meaning or disappears.
FORMAT_VERSION = 4


class ChannelLine(msgspec.Struct, frozen=True):
    """Column of the samples, as the first line describes it.

    Parameters
    ----------
    name
        Name of the column.
    kind
        Kind of the column: ``piezo`` or another vibration sensor, ``force``, or ``strip``.
    finger
        Number of the finger; null for a sensor of no finger.
    unit
        Unit of the column's values.
    """

    name: str
    kind: str
    finger: Finger | None
    unit: str


class DescriptorLine(msgspec.Struct, frozen=True, kw_only=True, tag="descriptor"):
    """First line, which describes the source of the samples and their columns.

    Parameters
    ----------
    format, format_version
        ``firstcontact-live`` and the version of this format, 4.
    firmware, sensor, hand
        Names of the sender's firmware, sensor and hand; empty if unknown.
    source
        ``real``, ``twin``, ``synthetic`` or ``unknown``.
    predictor
        ``model`` (digest), ``detector``, ``anytime`` (network) and noise ``floors`` of a device
        that predicts by itself; null for other devices.
    rate
        Sampling rate, Hz.
    fingers
        Names of the fingers by their numbers.
    channels
        Columns of the samples.
    """

    format: str = FORMAT
    format_version: int = FORMAT_VERSION
    firmware: str
    sensor: str
    hand: str
    source: str
    predictor: DevicePredictor | None
    rate: float
    fingers: tuple[str, ...] = tuple(finger_name(finger) for finger in Finger)
    channels: tuple[ChannelLine, ...]

    @classmethod
    def describe(cls, descriptor: Descriptor) -> DescriptorLine:
        """Return the first line for a source with this descriptor."""
        layout = descriptor.layout
        pairs = zip(layout.column_names, layout.column_channels, strict=True)
        return cls(
            firmware=descriptor.firmware,
            sensor=descriptor.sensor,
            hand=descriptor.hand,
            source=descriptor.source,
            predictor=descriptor.predictor,
            rate=layout.rate,
            channels=tuple(
                ChannelLine(name, c.sensor or c.kind, c.finger, c.unit) for name, c in pairs
            ),
        )


class MarkerLine(msgspec.Struct, frozen=True, tag="marker"):
    """Marker of a person or the device, attached to a sample.

    Parameters
    ----------
    sample, epoch
        Sample to which the marker is attached, and its epoch (run of the sample counter).
    text
        Text of the marker.
    """

    sample: int
    epoch: int
    text: str


#: State of the connection to the device: the fields of ``Health`` that do not change all the time.
LinkLine = msgspec.defstruct(
    "LinkLine",
    [
        (field.name, get_type_hints(Health)[field.name], field.default)
        for field in fields(Health)
        if field.name not in ("samples", "host_rate", "losses_known", "ended")
    ],
    tag="link",
    frozen=True,
    kw_only=True,
)
LinkLine.__doc__ = """State of the connection to the device, written whenever it changes."""


class FailedLine(msgspec.Struct, frozen=True, tag="failed"):
    """Report that an output failed. The others continue.

    Parameters
    ----------
    subject
        Name of the output: ``page``, ``lsl`` or ``foxglove``.
    reason
        Reason in a few words.
    """

    subject: str
    reason: str


def json_line(record: msgspec.Struct) -> str:
    return msgspec.json.encode(record).decode()


def marker_line(marker: Marker) -> str:
    return json_line(MarkerLine(marker.sample, marker.epoch, marker.text))


class JsonLinesSink:
    """Sink that writes each event immediately as a line of JSON to a stream."""

    name = "json"
    every = 0.1
    is_prompt = True

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._link: msgspec.Struct = LinkLine(connected=True)

    def open(self, descriptor: Descriptor) -> None:
        self._write([json_line(DescriptorLine.describe(descriptor))])

    def take(self, update: Update) -> None:
        lines = []
        link = msgspec.convert(update.health, LinkLine, from_attributes=True)
        if link != self._link:
            lines.append(json_line(link))
        self._link = link
        lines += [json_line(FailedLine(*failure)) for failure in update.failed.items()]
        lines += [marker_line(m) for a in update.arrivals for m in a.markers]
        lines += [json_line(event) for event in update.events]
        if lines:
            self._write(lines)

    def close(self) -> None:
        """Do nothing: all lines were written already, and the stream stays open."""

    def _write(self, lines: Sequence[str]) -> None:
        self._stream.write("".join(line + "\n" for line in lines))
        self._stream.flush()


JSON = OutputKind("json", lambda session, options: JsonLinesSink(sys.stdout), to_stdout=True)
