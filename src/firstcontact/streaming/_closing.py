"""State of the closing in progress."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import (
    Block,
    ChannelKind,
    ClosingSpeed,
    Contact,
    Finger,
    Layout,
    first_closed_sample,
)
from firstcontact.streaming._estimates import ClosingEstimates


@dataclass(slots=True)
class OpenClosing:
    """Closing in progress.

    Parameters
    ----------
    start
        Sample from which contacts count.
    epoch
        Epoch of the samples.
    estimates
        Estimates of the closing; None without a model.
    end
        Number of the first sample after the pinch; 0 before the first contact.
    contacts
        Contacts so far.
    closing_speed
        Closing speed before the first contact, as the hand measured it; None if unknown.
    unmeasured
        First contact, until the closing speed before it is requested; then None.
    """

    start: int
    epoch: int
    estimates: ClosingEstimates | None = None
    end: int = 0
    contacts: list[Contact] = field(default_factory=list)
    closing_speed: ClosingSpeed | None = None
    unmeasured: Contact | None = None


class Strips:
    """Collector of the first contact of each strip in a closing.

    Parameters
    ----------
    layout
        Columns of the samples.
    """

    def __init__(self, layout: Layout) -> None:
        self._columns = {f: layout.columns(ChannelKind.STRIP, f) for f in Finger}
        self.begin()

    def begin(self) -> None:
        """Begin a closing: forget the contacts of the previous closing."""
        self._closed: list[Contact] = []
        self._open: set[Finger] = set()

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """First contact of each strip, in order of time."""
        return tuple(sorted(self._closed, key=lambda contact: contact.sample))

    def watch(self, block: Block, end: int | None) -> None:
        """Process samples of the closing. Samples from ``end`` on are ignored."""
        for finger, columns in self._columns.items():
            if not columns or any(contact.finger is finger for contact in self._closed):
                continue
            values = block.data[:, columns[0]]
            if finger in self._open and not values.any():
                continue
            is_closed = values > 0
            if finger not in self._open:
                if is_closed.all():
                    continue  # held since before this closing
                self._open.add(finger)
                is_closed = is_closed & (np.cumsum(~is_closed) > 0)
            sample = first_closed_sample(is_closed, block.first_sample)
            if sample is not None and (end is None or sample < end):
                self._closed.append(Contact(finger, sample, sample))
