"""Reader of recordings (MCAP files), which reads damaged ones, too, and reports what is lost."""

from __future__ import annotations

import logging
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from itertools import groupby, pairwise
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, FileError, InputError
from firstcontact.core.files import AnyPath
from firstcontact.core.text import counted
from firstcontact.recording._chunks import FileBytes, Record, read_chunks
from firstcontact.recording._stretch import SPAN, Span, Store, Stretch, merge, usable_block
from firstcontact.recording.messages import (
    HAND,
    Header,
    Marker,
    PinchMark,
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
        Sentences about data that are damaged, lost, repeated or out of order.
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
        return sum(s.end - s.first_sample for s in self.stretches)

    @property
    def duration(self) -> float:
        """Duration of the samples that could be read, s."""
        return self.samples / self.header.layout.rate

    @property
    def hand_positions(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Positions of the fingertip that the hand reported: times in s, and positions in m.

        Both arrays have the shape (n,), and are empty for a hand without positions. The times are
        on the device's clock, which starts again with each epoch.
        """
        group = next((g for g in self.header.layout.groups if g.name == HAND), None)
        blocks = () if group is None else self.groups[HAND]
        if group is None or not blocks:
            return np.zeros(0), np.zeros(0)
        numbers = [np.arange(b.first_sample, b.end) for b in blocks]
        travel = [group.layout.physical(b.data, (0,))[:, 0] for b in blocks]
        return np.concatenate(numbers) / group.layout.rate, np.concatenate(travel)


def read_recording(path: AnyPath) -> Recording:
    """Read a recording (.mcap), also a damaged one, or one whose writer was killed.

    All intact parts are read; one intact copy of the header is enough. ``skipped`` describes the
    parts that are left out. Samples stay in the file until they are used, so keep it unchanged.

    Raises
    ------
    InputError
        The file cannot be opened, is not a recording, has another version, or has no readable
        header.
    """
    path = Path(path)
    data, damage = FileBytes(path), list[str]()
    messages = _Messages(path, data)
    for place, records in read_chunks(path, data, damage):
        messages.add(place, records)
    header, index = messages.header, messages.index
    stretches, losses = index.stretches("/samples")
    groups = {}
    for group in header.layout.groups:
        groups[group.name], group_losses = index.stretches(f"/samples/{group.name}")
        losses += [f"group {group.name}: {loss}" for loss in group_losses]
    pinches, lost_marks = _parse_usable(messages.texts["/pinch"], read_mark, "pinch marks")
    pinches = _distinct_marks(path, pinches)
    markers, lost_markers = _parse_usable(messages.texts["/marker"], read_marker, "markers")
    skipped = (*damage, *losses, *_missing_marks(pinches), *lost_marks, *lost_markers)
    for sentence in skipped:
        _log.info("%s: %s", path, sentence)
    return Recording(path, header, stretches, pinches, markers, skipped, groups)


class _Messages:
    """Messages of a recording file: texts by topic, and the positions of samples in the file."""

    def __init__(self, path: Path, data: FileBytes) -> None:
        self._path, self._data = path, data
        self.texts: defaultdict[str, list[bytes]] = defaultdict(list)
        self._headers: dict[bytes, None] = {}
        self._topics = dict(TOPICS)
        self._index: _Index | None = None
        self._waiting: list[tuple[str, int, bytes, slice]] = []  # until the first header

    def add(self, place: slice, records: Iterable[Record]) -> None:
        for number, content in records:
            if isinstance(content, str):
                self._topics[number] = content
                continue
            topic = self._topics.get(number, str(number))
            if topic == "/header":
                self._headers.setdefault(content.rstrip(b" "))
            elif topic in TOPICS.values() and topic != "/samples":
                self.texts[topic].append(content)
            else:
                self._waiting.append((topic, number, content, place))
        if self._index is None and self._headers:
            with suppress(InputError):
                self._index = _Index(self._path, self._data, self.header)
        if self._index is not None:
            for message in self._waiting:
                self._index.add(*message)
            self._waiting = []

    @property
    def header(self) -> Header:
        """First usable header in the file.

        Raises the error of the first header if no header is usable.
        """
        return _first_usable_header(self._path, self._headers)

    @property
    def index(self) -> _Index:
        return self._index or _Index(self._path, self._data, self.header)


class _Index:
    """Index of the messages with samples: their positions in a file, by topic."""

    def __init__(self, path: Path, data: FileBytes, header: Header) -> None:
        self._path = path
        layout = header.layout
        self._stores = {"/samples": Store(path, data, header.dtype, layout.width)}
        self._topics = {"/samples": "/samples"}
        for number, group in enumerate(layout.groups, FIRST_GROUP):
            topic = f"/samples/{group.name}"
            self._stores[topic] = Store(path, data, header.dtype, group.layout.width)
            # Without the first chunk, a channel has only its number.
            self._topics |= {topic: topic, str(number): topic}
        self._spans: defaultdict[str, list[tuple[int, Span]]] = defaultdict(list)
        self._bad: Counter[str] = Counter()
        self._misfits: set[str] = set()

    def add(self, topic: str, channel: int, content: bytes, place: slice) -> None:
        if topic not in self._topics:
            return
        topic = self._topics[topic]
        block = usable_block(content, self._stores[topic].dtype)
        if block is None:
            self._bad[topic] += 1
        elif block.data.shape[1] != self._stores[topic].columns:
            self._misfits.add(topic)
        else:
            spans, first = self._spans[topic], block.first_sample
            span = Span(channel, first, first, block.end, place.start, place.stop)
            epoch, last = spans[-1] if spans else (-1, span)
            if (epoch, last.channel, last.end) == (block.epoch, channel, first) and (
                place.stop - last.start <= SPAN or place.stop == last.stop
            ):
                spans[-1] = epoch, last._replace(end=block.end, stop=place.stop)
            else:
                spans.append((block.epoch, span))

    def stretches(self, topic: str) -> tuple[tuple[Block, ...], list[str]]:
        """Return the samples of a topic as blocks without gaps, and sentences about lost samples.

        Raises FileError if the samples do not fit the header, or contradict each other.
        """
        store = self._stores[topic]
        if topic in self._misfits:
            raise FileError(
                f"{self._path}: {topic} does not have the {store.columns} columns of the header's "
                "layout: write the file again from its source"
            )
        try:
            stretches, losses = join([Stretch(store, e, [span]) for e, span in self._spans[topic]])
        except ValueError as error:
            raise _merged_error(self._path, f"in {topic} {error}") from error
        bad = self._bad[topic]
        unusable = [f"{bad} messages hold no samples and were left out"] if bad else []
        return stretches, [*unusable, *losses]


def _first_usable_header(path: Path, headers: Iterable[bytes]) -> Header:
    """Parse the JSON texts of all headers in a file. Return the first usable header.

    Raises the error of the first header if no header is usable.
    """
    first: InputError | None = None
    usable: list[Header] = []
    for data in headers:
        try:
            header = read_header(data, f"{path}: /header")
        except InputError as error:
            first = first or error
            continue
        if usable and header != usable[0]:
            raise _merged_error(path, "two different headers")
        usable.append(header)
    if usable:
        return usable[0]
    raise first or FileError(
        f"{path} is not a firstcontact recording, or was cut off before its first samples (no "
        "readable /header): convert files of other programs with `firstcontact import`"
    )


def _merged_error(path: Path, fault: str) -> InputError:
    """Return the error for a file into which several recordings were merged.

    ``fault`` completes the sentence "the file has ...", and is what shows the merge.
    """
    return FileError(
        f"{path} has {fault}: several recordings were merged into it, so use the recordings that "
        "it was made from, one by one"
    )


def _distinct_marks(path: Path, marks: Iterable[PinchMark]) -> tuple[PinchMark, ...]:
    """Return the distinct marks of pinches. Raise FileError if one pinch has two labels."""
    distinct = tuple(dict.fromkeys(marks))
    doubled = [n for n, times in Counter(m.number for m in distinct).items() if times > 1]
    if doubled:
        raise _merged_error(path, f"two pinches of the number {doubled[0]}")
    for one, other in pairwise(sorted(distinct, key=lambda m: (m.epoch, m.first_sample))):
        shared = min(one.end, other.end) - other.first_sample if one.epoch == other.epoch else 0
        longer = max(m.end - m.first_sample for m in (one, other))
        # Pinches around close contacts share a few samples.
        if one.label != other.label and 2 * (shared - 1) > longer:
            raise _merged_error(
                path, f"two labels for the samples from number {other.first_sample} on"
            )
    return distinct


def _parse_usable(
    messages: list[bytes], read: Callable[[bytes, str], T], noun: str
) -> tuple[tuple[T, ...], list[str]]:
    """Parse messages by ``read``. Return the results, and a sentence about unusable messages.

    The sentence is in a list, which is empty if all are usable. ``noun`` is its word for a message.
    """
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
    """Join consecutive blocks of each epoch. Return the blocks, and sentences about lost samples.

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
            overlap = min(farthest.end, block.end) - block.first_sample
            shared = block.first_sample, block.first_sample + overlap
            if not np.array_equal(farthest.part(*shared).data, block.part(*shared).data):
                raise ValueError(f"two values for samples from number {block.first_sample} on")
            doubled += overlap
            rest = block.part(block.first_sample + overlap, block.end)
        if rest.end > rest.first_sample:
            accepted.append(rest)
            farthest = block
    stretches = merge(accepted)
    gaps = [b.first_sample - a.end for a, b in pairwise(stretches)]
    if doubled:
        trouble.append(f"{doubled} samples came twice; the first were kept")
    if gaps:
        missing = f"{counted(sum(gaps), 'sample')} {'is' if sum(gaps) == 1 else 'are'} missing"
        trouble.append(f"{missing} in {counted(len(gaps), 'gap')}")
    return stretches, trouble
