"""Blocks of a recording whose samples stay in the file until they are used."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, FileError, merge_blocks
from firstcontact.recording._chunks import FileBytes, search
from firstcontact.recording.messages import LARGEST, LAST_SAMPLE, read_block

#: Length of the bytes that are read for any sample in them.
SPAN = 1 << 18


class Span(NamedTuple):
    """Position in a file of the samples ``first`` to ``end`` (exclusive), which have no gap.

    Their messages have the number ``channel`` and begin with the sample ``begin``. They are in the
    chunks from byte ``start`` to ``stop`` of the file.
    """

    channel: int
    begin: int
    first: int
    end: int
    start: int
    stop: int


@dataclass(slots=True)
class Store:
    """Open file from which samples of one topic are read, with a cache of the last ones.

    ``dtype`` and ``columns`` are the samples' data type and number of columns.
    """

    path: Path
    data: FileBytes
    dtype: str
    columns: int
    recent: tuple[tuple[int, ...], list[Block]] = field(default_factory=lambda: ((), []))

    def read(self, span: Span, epoch: int) -> list[Block]:
        key = (epoch, span.channel, span.begin, span.start, span.stop)
        last, blocks = self.recent
        if key == last:
            return blocks
        blocks, expected = [], span.begin
        for _, records in search(self.path, self.data[span.start : span.stop], [], 0):
            for channel, content in records:
                if channel != span.channel or not isinstance(content, bytes):
                    continue
                block = usable_block(content, self.dtype)
                if block is not None and (block.first_sample, block.epoch) == (expected, epoch):
                    blocks.append(block)
                    expected = block.end
        if expected < span.end:
            raise FileError(f"{self.path} was changed while it was read: read it again")
        self.recent = key, blocks
        return blocks


def usable_block(content: bytes, dtype: str) -> Block | None:
    """Return the samples in a message as a block; None if the message is not usable."""
    try:
        block = read_block(content, dtype)
    except ValueError:
        return None
    return block if block.end <= LAST_SAMPLE and _is_finite(block) else None


def _is_finite(block: Block) -> bool:
    """Return True if all samples of a block are finite and at most ``LARGEST``."""
    if block.data.dtype.kind != "f":
        return True
    with np.errstate(invalid="ignore"):
        return bool((np.abs(block.data) <= LARGEST).all())


class Stretch(Block):
    """Block whose samples stay in a file until ``data`` is used."""

    store: Store
    spans: tuple[Span, ...]

    def __init__(self, store: Store, epoch: int, spans: Sequence[Span]) -> None:
        object.__setattr__(self, "first_sample", spans[0].first)
        object.__setattr__(self, "epoch", epoch)
        self.__dict__.update(store=store, spans=tuple(spans))

    def __reduce__(self) -> tuple[Any, ...]:
        return Block, (self.data, self.first_sample, self.epoch)

    def __repr__(self) -> str:
        return f"Stretch({self.first_sample} to {self.end}, epoch {self.epoch})"

    @property
    def end(self) -> int:
        return self.spans[-1].end

    @cached_property
    def data(self) -> NDArray[Any]:
        rows = np.empty((self.end - self.first_sample, self.store.columns), self.store.dtype)
        for span in self.spans:
            for block in self.store.read(span, self.epoch):
                low, high = max(block.first_sample, span.first), min(block.end, span.end)
                if low < high:
                    place = slice(low - self.first_sample, high - self.first_sample)
                    rows[place] = block.part(low, high).data
        return rows

    def part(self, first: int, end: int) -> Block:
        low = bisect_right(self.spans, first, key=lambda span: span.end)
        high = bisect_left(self.spans, end, key=lambda span: span.first)
        spans = [
            span._replace(first=max(first, span.first), end=min(end, span.end))
            for span in self.spans[low:high]
        ]
        if not spans:
            return Block(np.empty((0, self.store.columns), self.store.dtype), first, self.epoch)
        return Stretch(self.store, self.epoch, spans)


def merge(blocks: Sequence[Block]) -> list[Block]:
    """Merge blocks of one epoch that follow each other without a gap, but read no samples."""
    stretches = [block for block in blocks if isinstance(block, Stretch)]
    if len(stretches) < len(blocks):
        return merge_blocks(blocks)
    runs: list[list[Stretch]] = []
    for stretch in stretches:
        if runs and stretch.first_sample == runs[-1][-1].end:
            runs[-1].append(stretch)
        else:
            runs.append([stretch])
    return [Stretch(r[0].store, r[0].epoch, [s for part in r for s in part.spans]) for r in runs]
