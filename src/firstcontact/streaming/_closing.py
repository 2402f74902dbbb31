"""What is known of the closing that goes on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import Block, ChannelKind, Contact, Finger, Layout, first_closed_sample
from firstcontact.signal import WindowStream
from firstcontact.streaming._events import Estimated
from firstcontact.streaming._running import RunningAnswers


@dataclass(slots=True)
class OpenClosing:
    """Contacts, answers and strips of a closing so far.

    Parameters
    ----------
    armed
        Sample from which contacts count.
    epoch
        Of the samples.
    windows
        Of the models of fixed windows.
    asked
        Windows still to come.
    running
        Of the any-time model; None without one.
    end
        One past the last sample that belongs to the pinch, once it has a contact.
    """

    armed: int
    epoch: int
    windows: WindowStream
    asked: int
    running: RunningAnswers | None = None
    end: int = 0
    contacts: list[Contact] = field(default_factory=list)
    estimates: list[Estimated] = field(default_factory=list)
    refused: str = ""

    @property
    def due(self) -> int | None:
        """So many more samples complete a window or an answer; None where none has begun."""
        running = None if self.running is None else self.running.due
        return min((n for n in (self.windows.due, running) if n is not None), default=None)


class Strips:
    """Where each strip closed for the first time in a closing.

    Parameters
    ----------
    layout
        Of the samples.
    """

    def __init__(self, layout: Layout) -> None:
        self._columns = {f: layout.columns(ChannelKind.STRIP, f) for f in Finger}
        self.begin()

    def begin(self) -> None:
        """A closing begins."""
        self._found: dict[Finger, int] = {}
        self._open: set[Finger] = set()

    @property
    def closed(self) -> tuple[tuple[Finger, int], ...]:
        """Finger and sample of each, in order."""
        return tuple(sorted(self._found.items(), key=lambda item: item[1]))

    def watch(self, block: Block, end: int | None) -> None:
        """Look at samples of the closing; those from ``end`` on belong to no pinch."""
        for finger, columns in self._columns.items():
            if not columns or finger in self._found:
                continue
            closed = block.data[:, columns[0]] > 0
            if finger not in self._open:
                if closed.all():
                    continue  # held since before this closing
                self._open.add(finger)
                closed = closed & (np.cumsum(~closed) > 0)
            sample = first_closed_sample(closed, block.first_sample)
            if sample is not None and (end is None or sample < end):
                self._found[finger] = sample
