"""Plotted traces: the signals of the last seconds, and a close-up of the latest first contact."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, ChannelKind, Contact, Finger, Layout

#: Time that the traces show, s.
SECONDS = 2.0
#: Number of columns in that time, as many as a good tablet has pixels for a trace.
COLUMNS = 1200
#: Number of epochs whose samples can still be placed.
EPOCHS = 8
#: Time that the close-up shows before and after the contact, s.
BEFORE = 0.005
AFTER = 0.035
#: Time of samples kept for a contact that is reported late, s.
HELD = 0.5


def finger_place(finger: Finger | None) -> int:
    """Return the index of a finger's name and colour on the page; 2 for no finger."""
    return len(Finger) if finger is None else int(finger)


class Columns:
    """Ring buffer of plotted columns, which are a pixel wide.

    A column holds the minimum and the maximum of each signal over a few samples.
    """

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
        """Number of the newest column, which is incomplete: samples are still added to it."""
        return max(self._top, 0)

    @property
    def first(self) -> int:
        """Number of the oldest stored column."""
        return max(0, self._top - self._size + 1)

    def add(self, block: Block) -> None:
        """Add the samples of a block. Samples that were added before are ignored."""
        if block.epoch != self._epoch:
            self._epoch = block.epoch
            # An empty column between two epochs: nothing is joined.
            base = self._top + 2 if self._top >= 0 else 0
            self._epochs[block.epoch] = block.first_sample, base
            if len(self._epochs) > EPOCHS:
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
        self._discard_oldest(int(place[-1]))
        starts = np.flatnonzero(np.diff(place, prepend=place[0] - 1))
        low = np.fmin.reduceat(values, starts, axis=0)
        high = np.fmax.reduceat(values, starts, axis=0)
        is_visible = place[starts] >= self.first
        slots = place[starts][is_visible] % self._size
        self._ring[slots, :, 0] = np.fmin(self._ring[slots, :, 0], low[is_visible])
        self._ring[slots, :, 1] = np.fmax(self._ring[slots, :, 1], high[is_visible])

    def _discard_oldest(self, top: int) -> None:
        fresh = np.arange(max(self._top + 1, top - self._size + 1), top + 1)
        self._ring[fresh % self._size] = np.nan
        self._top = max(self._top, top)

    def place(self, sample: int, epoch: int) -> float | None:
        """Return the position of a sample in columns, with fraction; None for an old epoch."""
        if epoch not in self._epochs:
            return None
        origin, base = self._epochs[epoch]
        return base + (sample - origin) / self.samples

    def since(self, column: int) -> tuple[int, NDArray[np.float32]]:
        """Return the number of the first column and all complete columns, from ``column`` on.

        The array has a row per column, with the minima and maxima of the signals.
        """
        first = min(max(column, self.first), self.end)
        return first, self._ring[np.arange(first, self.end) % self._size]


class Closeup:
    """Signals around the first contact of the latest closing, as a close-up plot."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._vibration = layout.columns(ChannelKind.VIBRATION)
        self._before = round(BEFORE * layout.rate)
        self._n = self._before + round(AFTER * layout.rate) + 1
        self._blocks: deque[Block] = deque()
        self._held = 0
        self._trace = np.full((self._n, len(self._vibration)), np.nan)
        self._contact: Contact | None = None
        self._first = 0
        self._epoch = -1
        self._marks: list[dict[str, Any]] = []

    def add(self, block: Block) -> bool:
        """Add a block of samples. Return True if the close-up has changed."""
        self._blocks.append(block)
        self._held += len(block.data)
        while self._held - len(self._blocks[0].data) >= HELD * self._layout.rate:
            self._held -= len(self._blocks.popleft().data)
        return self._fill(block)

    def begin(self, contact: Contact, epoch: int) -> None:
        """Show the samples around this first contact, until :meth:`clear` or another call."""
        self._contact, self._epoch = contact, epoch
        self._first = contact.sample - self._before
        self._trace[:] = np.nan
        self._marks = []
        self.mark(contact)
        for block in self._blocks:
            self._fill(block)

    def mark(self, contact: Contact) -> None:
        if self._contact is not None:
            elapsed = (contact.sample - self._contact.sample) / self._layout.rate
            mark = {"finger": finger_place(contact.finger), "ms": round(1e3 * elapsed, 2)}
            self._marks.append(mark)

    def clear(self) -> None:
        """Show no samples until the next call of :meth:`begin`."""
        self._contact = None

    def _fill(self, block: Block) -> bool:
        if self._contact is None or block.epoch != self._epoch:
            return False
        start = max(block.first_sample, self._first)
        end = min(block.end, self._first + self._n)
        if start >= end:
            return False
        rows = block.data[start - block.first_sample : end - block.first_sample]
        volts = self._layout.physical(rows, self._vibration)
        self._trace[start - self._first : end - self._first] = volts
        return True

    def tree(self) -> dict[str, Any] | None:
        """Return the close-up as JSON data: times (ms), traces and contacts; None if it is empty.

        Missing samples are NaN.
        """
        if self._contact is None:
            return None
        ms = (np.arange(self._n) - self._before) / self._layout.rate * 1e3
        traces = self._trace.T.round(4).tolist()
        return {"ms": ms.round(3).tolist(), "traces": traces, "marks": self._marks}
