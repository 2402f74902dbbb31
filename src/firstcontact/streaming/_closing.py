"""State of the closing (one movement of the hand around an object) that is in progress."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from msgspec.structs import replace

from firstcontact.core import Block, ChannelKind, ClosingSpeed, Contact, Finger, Layout
from firstcontact.core.pinch import first_closed_sample
from firstcontact.streaming.events import Estimate, judged


@dataclass(slots=True)
class OpenClosing:
    start: int
    epoch: int
    heard: int
    contacts: list[Contact] = field(default_factory=list)
    made: list[tuple[int, Estimate]] = field(default_factory=list)
    is_settled: bool = False
    reason: str = ""
    shape: str = ""
    closing_speed: ClosingSpeed | None = None
    unmeasured: Contact | None = None
    #: Wait for a processor, and longest time without running for any reason, until it settled, s.
    queued: float = 0.0
    stalled: float = 0.0

    @property
    def second(self) -> Contact | None:
        return self.contacts[1] if len(self.contacts) > 1 else None

    def withdraw(self) -> None:
        self.contacts, self.made = [], []
        self.is_settled, self.reason, self.shape = False, "", ""
        self.closing_speed = self.unmeasured = None

    def settle(self, last: int, rate: float, *, real_time: bool) -> Estimate | None:
        """Mark the newest estimate as final and return it; None without one.

        Estimates that use samples after number ``last`` are dropped first.
        """
        self.is_settled = True
        self.made = [pair for pair in self.made if pair[0] <= last]
        if not self.made:
            return None
        used, estimate = self.made[-1]
        final = replace(estimate, final=True)
        if self.second is not None:
            offset = (self.second.sample - self.contacts[0].sample) / rate
            final = judged(final, offset, real_time=real_time)
        self.made[-1] = used, final
        self.reason = ""
        return final


class Strips:
    """Collector of true contacts: the first one that each copper strip shows in a closing."""

    def __init__(self, layout: Layout) -> None:
        columns = {f: layout.columns(ChannelKind.STRIP, f) for f in Finger}
        self._columns = {finger: places[0] for finger, places in columns.items() if places}
        #: True if the layout has a strip.
        self.exist = layout.has_strip
        self._closed: list[Contact] = []
        self._open: set[Finger] = set()

    def begin(self) -> None:
        self._closed, self._open = [], set()

    @property
    def contacts(self) -> tuple[Contact, ...]:
        return tuple(sorted(self._closed, key=lambda contact: contact.sample))

    def watch(self, block: Block) -> None:
        for finger, column in self._columns.items():
            if any(contact.finger is finger for contact in self._closed):
                continue
            values = block.data[:, column]
            if finger in self._open and not values.any():
                continue
            is_closed = values > 0
            if finger not in self._open:
                if is_closed.all():
                    continue  # held since before this closing
                self._open.add(finger)
                is_closed = is_closed & (np.cumsum(~is_closed) > 0)
            sample = first_closed_sample(is_closed, block.first_sample)
            if sample is not None:
                self._closed.append(Contact(finger, sample, sample))
