"""Read a recording, whatever happened to it, and say what is missing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from mcap.records import Channel, McapRecord, Message

from firstcontact.core import MOST_GROUPS, AnyPath, Block, InputError
from firstcontact.recording import _samples as samples
from firstcontact.recording._chunks import scan
from firstcontact.recording._header import (
    LAST_SAMPLE,
    Header,
    Marker,
    PinchMark,
    read_header,
    read_mark,
    read_marker,
)
from firstcontact.recording._stretches import join

T = TypeVar("T")

#: Channel numbers that the format fixes, for a file whose first chunk is lost.
TOPICS = {1: "/header", 2: "/samples", 3: "/pinch", 4: "/marker"}
#: Number of the first group's channel; the others follow in the order of the layout.
FIRST_GROUP = 5
#: So many gaps in the count of pinches are told one by one.
_TOLD = 10


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
    groups
        Unbroken samples of each slower group, by their own count.
    skipped
        What was damaged, lost, doubled or out of order: one sentence each.
    """

    path: Path
    header: Header
    stretches: tuple[Block, ...] = ()
    pinches: tuple[PinchMark, ...] = ()
    markers: tuple[Marker, ...] = ()
    skipped: tuple[str, ...] = ()
    groups: Mapping[str, tuple[Block, ...]] = field(default_factory=dict)

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
    """Messages by topic, in the order of the file; those of groups by topic or number."""

    headers: list[bytes] = field(default_factory=list)
    blocks: list[bytes] = field(default_factory=list)
    pinches: list[bytes] = field(default_factory=list)
    markers: list[bytes] = field(default_factory=list)
    groups: dict[str, list[bytes]] = field(default_factory=dict)


def read_recording(path: AnyPath) -> Recording:
    """Read every complete chunk of a recording.

    Any intact header will do. What is in intact chunks and still cannot be used is
    left out, and counted in ``skipped``.

    Raises
    ------
    InputError
        The file cannot be opened, is not a recording, or is of another
        version, or nothing in it says what its columns are.
    """
    path = Path(path)
    scanned = scan(path)
    found = _sorted(scanned.records)
    header = _header(path, found.headers)
    blocks, bad = _blocks(path, "/samples", found.blocks, header.dtype, header.layout.width)
    stretches, losses = join(blocks)
    groups = {}
    for number, group in enumerate(header.layout.groups, FIRST_GROUP):
        topic = f"/samples/{group.name}"
        messages = found.groups.get(str(number), []) + found.groups.get(topic, [])
        its, its_bad = _blocks(path, topic, messages, header.dtype, group.layout.width)
        groups[group.name], its_losses = join(its)
        losses += tuple(f"group {group.name}: {said}" for said in (*its_bad, *its_losses))
    pinches, lost_marks = _read(found.pinches, read_mark, "pinch marks")
    markers, lost_markers = _read(found.markers, read_marker, "markers")
    skipped = (
        *scanned.skipped,
        *bad,
        *losses,
        *_lost_marks(pinches),
        *lost_marks,
        *lost_markers,
    )
    return Recording(path, header, stretches, pinches, markers, skipped, groups)


def _sorted(records: Iterable[McapRecord]) -> _Found:
    found = _Found()
    lists = {
        "/header": found.headers,
        "/samples": found.blocks,
        "/pinch": found.pinches,
        "/marker": found.markers,
    }
    topics = dict(TOPICS)
    for record in records:
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            topic = topics.get(record.channel_id, str(record.channel_id))
            known = lists.get(topic)
            if known is not None:
                known.append(record.data)
            elif record.channel_id < FIRST_GROUP + MOST_GROUPS:
                found.groups.setdefault(topic, []).append(record.data)
    return found


def _header(path: Path, headers: list[bytes]) -> Header:
    """The first that can be used; where none can, what is wrong with the first."""
    first: InputError | None = None
    for data in headers:
        try:
            return read_header(data, f"{path}: /header")
        except InputError as error:
            first = first or error
    raise first or InputError(
        f"{path} is not a firstcontact recording, or is cut off before its first samples (no "
        "readable /header): bring other data in with `firstcontact import`"
    )


def _blocks(
    path: Path, topic: str, messages: list[bytes], dtype: str, columns: int
) -> tuple[list[Block], list[str]]:
    """The samples of a file, and how many messages hold none."""
    blocks = []
    bad = 0
    for data in messages:
        try:
            block = samples.decode(data, dtype)
        except ValueError:
            bad += 1
            continue
        if block.data.shape[1] != columns:
            raise InputError(
                f"{path}: {topic} does not have the {columns} columns of the header's layout: "
                "write the file again from its source"
            )
        if block.end > LAST_SAMPLE or not _finite(block):
            bad += 1
            continue
        blocks.append(block)
    return blocks, [f"{bad} messages hold no samples and were left out"] if bad else []


def _finite(block: Block) -> bool:
    """Whether all values can be computed with; integers always can."""
    if block.data.dtype.kind != "f":
        return True
    with np.errstate(invalid="ignore"):
        return bool((np.abs(block.data) <= samples.LARGEST).all())


def _read(
    messages: list[bytes], read: Callable[[bytes, str], T], what: str
) -> tuple[tuple[T, ...], list[str]]:
    """What can be used of these messages, and how many cannot."""
    good = []
    bad = 0
    why = ""
    for data in messages:
        try:
            good.append(read(data, "the first of them"))
        except InputError as error:
            bad += 1
            why = why or str(error)
    return tuple(good), [f"{bad} {what} cannot be used and were left out ({why})"] if bad else []


def _lost_marks(pinches: tuple[PinchMark, ...]) -> list[str]:
    numbers = [-1, *sorted({p.number for p in pinches})]
    gaps = [(a + 1, b - 1) for a, b in pairwise(numbers) if b > a + 1]
    if not gaps:
        return []
    told = [f"{a}" if a == b else f"{a} to {b}" for a, b in gaps[:_TOLD]]
    more = f" and in {len(gaps) - _TOLD} more gaps" if len(gaps) > _TOLD else ""
    return [f"the marks of pinches {', '.join(told)}{more} are lost: their labels are not known"]
