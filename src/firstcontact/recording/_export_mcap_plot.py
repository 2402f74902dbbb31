"""Exporter to an MCAP file that plotting tools read without a plug-in: ROS 2 Float64 topics.

Foxglove and PlotJuggler plot topics such as ``/vibration/piezo_index`` over time. Recordings store
many samples per message, because one message per sample would make them three times as large.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, Pinch, finger_name
from firstcontact.recording._formats import Exporter

_NANO = 1_000_000_000
#: Pause between two pinches that are not consecutive, ns.
PAUSE = _NANO // 2
#: Little-endian CDR of a number and of a text.
_NUMBER = struct.Struct("<4sd")
_TEXT = struct.Struct("<4sI")
_CDR = b"\x00\x01\x00\x00"
_SCHEMAS = {"std_msgs/msg/Float64": b"float64 data\n", "std_msgs/msg/String": b"string data\n"}
#: Topic of the contacts, as text.
CONTACTS = "/contacts"

Values = NDArray[np.float64]


def _write(dataset: Dataset, path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="firstcontact")
        schemas = {
            name: writer.register_schema(name, "ros2msg", text) for name, text in _SCHEMAS.items()
        }
        channels: dict[str, int] = {}

        def add(topic: str, kind: str, time: int, data: bytes) -> None:
            if topic not in channels:
                channels[topic] = writer.register_channel(topic, "cdr", schemas[kind])
            writer.add_message(channels[topic], time, data, time)

        begin = 0
        for pinch in dataset.pinches:
            topics = _signals_by_topic(pinch)
            last = begin
            for topic, (times, values) in topics.items():
                stamps = (begin + np.round(times * _NANO)).astype(np.int64).tolist()
                for stamp, value in zip(stamps, values.tolist(), strict=True):
                    if stamp >= 0:
                        message = _NUMBER.pack(_CDR, value)
                        add(topic, "std_msgs/msg/Float64", stamp, message)
                last = max([last, *stamps[-1:]])
            for at, sentence in _contact_texts(pinch):
                text = sentence.encode() + b"\0"
                stamp = begin + round(at * _NANO)
                add(CONTACTS, "std_msgs/msg/String", stamp, _TEXT.pack(_CDR, len(text)) + text)
            begin = last + PAUSE
        writer.finish()  # type: ignore[no-untyped-call]


def _signals_by_topic(pinch: Pinch) -> Mapping[str, tuple[Values, Values]]:
    """Return (times, values) of each channel, by MCAP topic.

    Times are in s from the start of the pinch, and values in physical units, both of shape (n,).
    """
    layout = pinch.layout
    physical = layout.physical(pinch.data, tuple(range(layout.width)))
    times = np.arange(len(pinch.data)) / layout.rate
    out = {
        f"/{channel.kind}/{name}": (times, physical[:, k])
        for k, (name, channel) in enumerate(
            zip(layout.column_names, layout.column_channels, strict=True)
        )
    }
    for group in layout.groups:
        if group.name in pinch.groups:
            at, values = pinch.group(group.name)
            for k, name in enumerate(group.layout.column_names):
                out[f"/{group.name}/{name}"] = (at, values[:, k])
    return out


def _contact_texts(pinch: Pinch) -> Iterator[tuple[float, str]]:
    """Yield (time, text) of each contact of a pinch. The time is in s from the pinch's start."""
    label = pinch.label
    words = ", ".join(filter(None, (label.object or "unknown object", label.value_words)))
    for contact in pinch.truth:
        at = (contact.sample - pinch.first_sample) / pinch.layout.rate
        yield at, f"{finger_name(contact.finger)}: {words}"


MCAP_PLOT = Exporter("mcap-plot", _write, "files", ("mcap",), groups=True)
