"""Close-up of the samples around the first contact of the latest closing."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from firstcontact.core import Block, ChannelKind, Contact, Finger, Layout

#: Time that is shown before and after the contact, s.
BEFORE = 0.005
AFTER = 0.035
#: Time of samples kept for a contact that is reported late, s.
HELD = 0.5


def finger_place(finger: Finger | None) -> int:
    """Return the index of a finger's name and colour on the page; 2 for a sensor of no finger."""
    return len(Finger) if finger is None else int(finger)


class Closeup:
    """Close-up of the samples around the first contact of the latest closing."""

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
        """Add a block. Return True if the close-up changed."""
        self._blocks.append(block)
        self._held += len(block.data)
        while self._held - len(self._blocks[0].data) >= HELD * self._layout.rate:
            self._held -= len(self._blocks.popleft().data)
        return self._fill(block)

    def begin(self, contact: Contact, epoch: int) -> None:
        """Show the samples around this first contact from now on."""
        self._contact, self._epoch = contact, epoch
        self._first = contact.sample - self._before
        self._trace[:] = np.nan
        self._marks = []
        self.mark(contact)
        for block in self._blocks:
            self._fill(block)

    def mark(self, contact: Contact) -> None:
        """Mark the contact of a finger in the close-up."""
        if self._contact is not None:
            elapsed = (contact.sample - self._contact.sample) / self._layout.rate
            self._marks.append(
                {"finger": finger_place(contact.finger), "ms": round(1e3 * elapsed, 2)}
            )

    def clear(self) -> None:
        """Show no contact until the next closing's first contact."""
        self._contact = None

    def _fill(self, block: Block) -> bool:
        if self._contact is None or block.epoch != self._epoch:
            return False
        start = max(block.first_sample, self._first)
        end = min(block.end, self._first + self._n)
        if start >= end:
            return False
        rows = block.data[start - block.first_sample : end - block.first_sample]
        self._trace[start - self._first : end - self._first] = self._layout.physical(
            rows, self._vibration
        )
        return True

    def tree(self) -> dict[str, Any] | None:
        """Return times (ms), traces and contacts for the page. Missing samples are None."""
        if self._contact is None:
            return None
        ms = (np.arange(self._n) - self._before) / self._layout.rate * 1e3
        traces = [
            [None if np.isnan(v) else round(float(v), 4) for v in self._trace[:, k]]
            for k in range(len(self._vibration))
        ]
        return {"ms": [round(float(t), 3) for t in ms], "traces": traces, "marks": self._marks}
