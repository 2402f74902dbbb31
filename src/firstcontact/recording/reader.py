"""Read a recording, whatever happened to it, and say what is missing."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.records import Channel, Message

from firstcontact.core import Block, InputError
from firstcontact.recording import samples
from firstcontact.recording.chunks import scan
from firstcontact.recording.header import FORMAT, VERSION, Header, Marker, PinchMark
from firstcontact.recording.stretches import join

#: Channel numbers that the format fixes, for a file whose first chunk is lost.
TOPICS = {1: "/header", 2: "/samples", 3: "/pinch", 4: "/marker"}


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """What could be read of a recording.

    Parameters
    ----------
    path
        The file.
    header
        What it says about itself.
    stretches
        Unbroken samples in the order of epoch and number; between two of one
        epoch, samples are missing.
    pinches
        Marks of the pinches.
    markers
        Words pinned to samples.
    skipped
        What was damaged, lost, doubled or out of order: one sentence each.
    """

    path: Path
    header: Header
    stretches: tuple[Block, ...] = ()
    pinches: tuple[PinchMark, ...] = ()
    markers: tuple[Marker, ...] = ()
    skipped: tuple[str, ...] = ()

    @property
    def samples(self) -> int:
        """Number of samples that could be read."""
        return sum(len(s.data) for s in self.stretches)

    @property
    def duration(self) -> float:
        """Time that these samples cover, s."""
        return self.samples / self.header.layout.rate


@dataclass(slots=True)
class _Found:
    """Messages by topic, in the order of the file."""

    headers: list[dict[str, Any]] = field(default_factory=list)
    blocks: list[bytes] = field(default_factory=list)
    pinches: list[PinchMark] = field(default_factory=list)
    markers: list[Marker] = field(default_factory=list)

    def add(self, topic: str, data: bytes) -> None:
        if topic == "/samples":
            self.blocks.append(data)
        elif topic == "/header":
            self.headers.append(json.loads(data))
        elif topic == "/pinch":
            self.pinches.append(PinchMark.from_json(json.loads(data)))
        elif topic == "/marker":
            self.markers.append(Marker(**json.loads(data)))


def read_recording(path: Path) -> Recording:
    """Read every complete chunk of a recording.

    Raises
    ------
    InputError
        The file cannot be opened, is not a recording, or is of another
        version, or nothing in it says what its columns are.
    """
    found = _Found()
    topics = dict(TOPICS)
    scanned = scan(path)
    for record in scanned.records:
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            try:
                found.add(topics.get(record.channel_id, ""), record.data)
            except (ValueError, KeyError, TypeError) as error:
                raise _foreign(path) from error
    header = _header(path, found.headers)
    try:
        blocks = [samples.decode(data, header.dtype) for data in found.blocks]
    except ValueError as error:
        raise _foreign(path) from error
    columns = len(header.layout.channels)
    if any(b.data.shape[1] != columns for b in blocks):
        raise InputError(
            f"{path}: /samples does not have the {columns} columns of the header's layout: "
            "write the file again from its source"
        )
    stretches, losses = join(blocks)
    skipped = (*scanned.skipped, *losses, *_lost_marks(found.pinches))
    return Recording(path, header, stretches, tuple(found.pinches), tuple(found.markers), skipped)


def _foreign(path: Path) -> InputError:
    return InputError(
        f"{path} is not a firstcontact recording, or is cut off before its first samples (no "
        "readable /header): bring other data in with `firstcontact import`"
    )


def _header(path: Path, headers: list[dict[str, Any]]) -> Header:
    if not headers or not isinstance(headers[0], dict) or headers[0].get("format") != FORMAT:
        raise _foreign(path)
    version = headers[0].get("version")
    if version != VERSION:
        raise InputError(
            f"{path}: /header says format version {version!r} and this reader knows {VERSION}: "
            "install the firstcontact that wrote it"
        )
    try:
        return Header.from_json(headers[0])
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(
            f"{path}: /header is not complete ({error}): write the file again from its source"
        ) from error


def _lost_marks(pinches: list[PinchMark]) -> list[str]:
    seen = {p.number for p in pinches}
    lost = sorted(set(range(max(seen, default=-1) + 1)) - seen)
    if not lost:
        return []
    return [
        f"the marks of pinches {', '.join(map(str, lost))} are lost: their labels are not known"
    ]
