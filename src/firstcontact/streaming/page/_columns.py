"""Traces reduced to the minimum and maximum of every few samples, so that no peak is lost."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, ChannelKind, Layout

#: Time that the traces show, s.
SECONDS = 2.0
#: Number of columns in that time, as many as a good tablet has pixels for a trace.
COLUMNS = 1200
#: Number of epochs whose samples can still be placed.
EPOCHS = 8


class Columns:
    """Ring buffer of columns. A column is the minimum and maximum of a few samples per channel."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._vibration = layout.columns(ChannelKind.VIBRATION)
        #: Number of samples in a column.
        self.samples = max(1, round(layout.rate * SECONDS / COLUMNS))
        # A quarter more than is shown, so that a viewer misses nothing in a short pause.
        visible = int(np.ceil(layout.rate * SECONDS / self.samples))
        self._size = visible + visible // 4
        self._ring = np.full((self._size, len(self._vibration), 2), np.nan, np.float32)
        self._top = -1
        self._epoch: int | None = None
        # First sample and first column of each of the last epochs: events may come a little late.
        self._epochs: dict[int, tuple[int, int]] = {}
        self._next = 0

    @property
    def end(self) -> int:
        """Number of the first incomplete column, to which samples are still added."""
        return max(self._top, 0)

    @property
    def first(self) -> int:
        """Number of the oldest stored column."""
        return max(0, self._top - self._size + 1)

    def add(self, block: Block) -> None:
        """Add the samples of a block. Repeated samples are ignored."""
        if len(block.data) == 0:
            return
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            # An empty column between two epochs: nothing is joined.
            base = self._top + 2 if self._top >= 0 else 0
            self._epochs[block.epoch] = block.first_sample, base
            while len(self._epochs) > EPOCHS:
                del self._epochs[next(iter(self._epochs))]
            self._next = block.first_sample
        late = max(0, self._next - block.first_sample)
        values = self._layout.physical(block.data[late:], self._vibration).astype(np.float32)
        if len(values) == 0:
            return
        samples = np.arange(block.first_sample + late, block.end)
        self._next = block.end
        origin, base = self._epochs[block.epoch]
        place = base + (samples - origin) // self.samples
        self._make_room(int(place[-1]))
        starts = np.flatnonzero(np.diff(place, prepend=place[0] - 1))
        low = np.fmin.reduceat(values, starts, axis=0)
        high = np.fmax.reduceat(values, starts, axis=0)
        is_visible = place[starts] >= self.first
        slots = place[starts][is_visible] % self._size
        self._ring[slots, :, 0] = np.fmin(self._ring[slots, :, 0], low[is_visible])
        self._ring[slots, :, 1] = np.fmax(self._ring[slots, :, 1], high[is_visible])

    def _make_room(self, top: int) -> None:
        fresh = np.arange(max(self._top + 1, top - self._size + 1), top + 1)
        self._ring[fresh % self._size] = np.nan
        self._top = max(self._top, top)

    def place(self, sample: int, epoch: int) -> float | None:
        """Return the position of a sample, in columns; None if its epoch is too old."""
        if epoch not in self._epochs:
            return None
        origin, base = self._epochs[epoch]
        return base + (sample - origin) / self.samples

    def since(self, column: int) -> tuple[int, NDArray[np.float32]]:
        """Return all stored complete columns from number ``column`` on."""
        first = min(max(column, self.first), self.end)
        return first, self._ring[np.arange(first, self.end) % self._size]
