"""Reader of recordings. It tolerates damage and reports losses."""

from __future__ import annotations

import logging
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, InputError, merge_blocks
from firstcontact.core.files import AnyPath
from firstcontact.core.text import counted
from firstcontact.recording._chunks import Record, read_chunks
from firstcontact.recording.messages import (
    HAND,
    LARGEST,
    LAST_SAMPLE,
    Header,
    Marker,
    PinchMark,
    read_block,
    read_header,
    read_mark,
    read_marker,
)

_log = logging.getLogger("firstcontact.recording")
T = TypeVar("T")

#: Channel numbers fixed by the format, for files whose first chunk is lost.
TOPICS = {1: "/header", 2: "/samples", 3: "/pinch", 4: "/marker"}
#: Channel number of the first group. The others follow in layout order.
FIRST_GROUP = 5


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Contents of a recording. In a damaged file, these are the parts that could be read.

    Parameters
    ----------
    path
        Path of the file.
    header
        Layout, source and other facts about the recording.
    stretches
        Longest possible blocks of samples without a gap, sorted by epoch (run of the device's
        sample counter) and sample number. Between two blocks of one epoch, samples are missing.
    pinches
        Positions of the pinches (closings of the hand), with labels and contacts.
    markers
        Texts of a person or a device, attached to samples.
    groups
        Blocks of each group of channels with a lower rate, in the group's own sample numbers.
    skipped
        Sentences about damaged, lost, repeated or disordered data.
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
        """Duration of the samples that could be read, s."""
        return self.samples / self.header.layout.rate

    @property
    def hand_positions(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Times, s, and positions of the fingertip, m, as the hand reported them; two arrays (n,).

        They are empty for a hand without positions. The times start again with each epoch.
        """
        group = next((g for g in self.header.layout.groups if g.name == HAND), None)
        blocks = () if group is None else self.groups[HAND]
        if group is None or not blocks:
            return np.zeros(0), np.zeros(0)
        numbers = [b.first_sample + np.arange(len(b.data)) for b in blocks]
        travel = [group.layout.physical(b.data, (0,))[:, 0] for b in blocks]
        return np.concatenate(numbers) / group.layout.rate, np.concatenate(travel)


def read_recording(path: AnyPath) -> Recording:
    """Read a recording (.mcap), also a damaged one, or one whose writer was killed.

    All intact parts are read; one intact copy of the header is enough. ``skipped`` describes the
    parts that are left out.

    Raises
    ------
    InputError
        The file cannot be opened, is not a recording, has another version, or has no readable
        header.
    """
    path = Path(path)
    records, damage = read_chunks(path)
    messages = _by_topic(records)
    header = _header(path, messages["/header"])
    layout = header.layout
    stretches, losses = _stretches(path, "/samples", messages["/samples"], header, layout.width)
    groups = {}
    for number, group in enumerate(layout.groups, FIRST_GROUP):
        topic = f"/samples/{group.name}"
        # Without the first chunk, a channel has only its number.
        of_group = messages[str(number)] + messages[topic]
        groups[group.name], group_losses = _stretches(
            path, topic, of_group, header, group.layout.width
        )
        losses += [f"group {group.name}: {loss}" for loss in group_losses]
    pinches, lost_marks = _read(messages["/pinch"], read_mark, "pinch marks")
    pinches = _distinct_marks(path, pinches)
    markers, lost_markers = _read(messages["/marker"], read_marker, "markers")
    skipped = (*damage, *losses, *_missing_marks(pinches), *lost_marks, *lost_markers)
    for sentence in skipped:
        _log.info("%s: %s", path, sentence)
    return Recording(path, header, stretches, pinches, markers, skipped, groups)


def _by_topic(records: Iterable[Record]) -> Mapping[str, list[bytes]]:
    """Return the contents of messages by topic, in file order."""
    messages: defaultdict[str, list[bytes]] = defaultdict(list)
    topics = dict(TOPICS)
    for number, content in records:
        if isinstance(content, str):
            topics[number] = content
        else:
            messages[topics.get(number, str(number))].append(content)
    return messages


def _header(path: Path, headers: list[bytes]) -> Header:
    """Return the usable header. If there is none, raise the error of the first header."""
    first: InputError | None = None
    usable: list[Header] = []
    for data in dict.fromkeys(data.rstrip(b" ") for data in headers):
        try:
            header = read_header(data, f"{path}: /header")
        except InputError as error:
            first = first or error
            continue
        if usable and header != usable[0]:
            raise _merged(path, "two different headers")
        usable.append(header)
    if usable:
        return usable[0]
    raise first or InputError(
        f"{path} is not a firstcontact recording, or was cut off before its first samples (no "
        "readable /header): convert files of other programs with `firstcontact import`"
    )


def _merged(path: Path, fault: str) -> InputError:
    """Return the error for a file in which a program has put several recordings together."""
    return InputError(
        f"{path} has {fault}: several recordings were merged into it, so use the recordings that "
        "it was made from, one by one"
    )


def _distinct_marks(path: Path, marks: Iterable[PinchMark]) -> tuple[PinchMark, ...]:
    """Return the marks without copies. Raise an error if one touch has two labels."""
    distinct = tuple(dict.fromkeys(marks))
    doubled = [n for n, times in Counter(m.number for m in distinct).items() if times > 1]
    if doubled:
        raise _merged(path, f"two pinches of the number {doubled[0]}")
    for one, other in pairwise(sorted(distinct, key=lambda m: (m.epoch, m.first_sample))):
        shared = min(one.end, other.end) - other.first_sample if one.epoch == other.epoch else 0
        longer = max(m.end - m.first_sample for m in (one, other))
        # Pinches around close contacts share a few samples.
        if one.label != other.label and 2 * (shared - 1) > longer:
            raise _merged(path, f"two labels for the samples from number {other.first_sample} on")
    return distinct


def _stretches(
    path: Path, topic: str, messages: list[bytes], header: Header, columns: int
) -> tuple[tuple[Block, ...], list[str]]:
    """Return the unbroken samples in the messages of a topic, and descriptions of losses."""
    blocks = []
    bad = 0
    for data in messages:
        try:
            block = read_block(data, header.dtype)
        except ValueError:
            bad += 1
            continue
        if block.data.shape[1] != columns:
            raise InputError(
                f"{path}: {topic} does not have the {columns} columns of the header's layout: "
                "write the file again from its source"
            )
        if block.end <= LAST_SAMPLE and _is_finite(block):
            blocks.append(block)
        else:
            bad += 1
    try:
        stretches, losses = join(blocks)
    except ValueError as error:
        raise _merged(path, f"in {topic} {error}") from error
    unusable = [f"{bad} messages hold no samples and were left out"] if bad else []
    return stretches, [*unusable, *losses]


def _is_finite(block: Block) -> bool:
    """Return True if all values are finite and not too large, as integers always are."""
    if block.data.dtype.kind != "f":
        return True
    with np.errstate(invalid="ignore"):
        return bool((np.abs(block.data) <= LARGEST).all())


def _read(
    messages: list[bytes], read: Callable[[bytes, str], T], noun: str
) -> tuple[tuple[T, ...], list[str]]:
    """Return the contents of the usable messages, and a note on the unusable ones."""
    good = []
    bad, reason = 0, ""
    for data in messages:
        try:
            good.append(read(data, "the first of them"))
        except InputError as error:
            bad, reason = bad + 1, reason or str(error)
    return tuple(good), [f"{bad} {noun} cannot be used and were left out ({reason})"] if bad else []


def _missing_marks(pinches: Iterable[PinchMark]) -> list[str]:
    numbers = {p.number for p in pinches}
    lost = max(numbers, default=-1) + 1 - len(numbers)
    return [f"marks of {counted(lost, 'pinch')} are lost, with their labels"] if lost else []


def join(blocks: Sequence[Block]) -> tuple[tuple[Block, ...], tuple[str, ...]]:
    """Join consecutive blocks epoch by epoch. Return them and descriptions of losses.

    Raises
    ------
    ValueError
        Two blocks give different values to one sample.
    """
    stretches: list[Block] = []
    losses: list[str] = []
    by_epoch = sorted(blocks, key=lambda b: b.epoch)  # stable: keeps file order within an epoch
    for epoch, group in groupby(by_epoch, key=lambda b: b.epoch):
        joined, trouble = _join_epoch(list(group))
        stretches += joined
        losses += [f"epoch {epoch}: {sentence}" for sentence in trouble]
    return tuple(stretches), tuple(losses)


def _join_epoch(blocks: list[Block]) -> tuple[list[Block], list[str]]:
    trouble: list[str] = []
    late = sum(b.first_sample < a.first_sample for a, b in pairwise(blocks))
    if late:
        trouble.append(f"{late} blocks were out of order and were put back")
    doubled = 0
    accepted: list[Block] = []
    farthest: Block | None = None  # as in the file: its part in ``accepted`` begins later
    for block in sorted(blocks, key=lambda b: b.first_sample):
        rest = block
        if farthest is not None and block.first_sample < farthest.end:
            overlap = min(farthest.end - block.first_sample, len(block.data))
            start = block.first_sample - farthest.first_sample
            if not np.array_equal(farthest.data[start : start + overlap], block.data[:overlap]):
                raise ValueError(f"two values for samples from number {block.first_sample} on")
            doubled += overlap
            rest = Block(block.data[overlap:], block.first_sample + overlap, block.epoch)
        if len(rest.data):
            accepted.append(rest)
            farthest = block
    stretches = merge_blocks(accepted)
    gaps = [b.first_sample - a.end for a, b in pairwise(stretches)]
    if doubled:
        trouble.append(f"{doubled} samples came twice; the first were kept")
    if gaps:
        missing = f"{counted(sum(gaps), 'sample')} {'is' if sum(gaps) == 1 else 'are'} missing"
        trouble.append(f"{missing} in {counted(len(gaps), 'gap')}")
    return stretches, trouble
