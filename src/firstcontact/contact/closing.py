"""Splitting of a stream of samples into closings with their contacts."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from dataclasses import dataclass

from firstcontact.chain import EventKind, Reason
from firstcontact.contact.contacts import contact_chain, contact_of
from firstcontact.contact.detector import Detector
from firstcontact.core import Block, Calibration, Contact, Layout


@dataclass(frozen=True, slots=True)
class ClosingBegan:
    """Event: the hand started to close. ``sample`` is the first sample of the closing."""

    sample: int
    epoch: int


@dataclass(frozen=True, slots=True, eq=False)
class ClosingSamples:
    """Event: new samples of a closing, with the contacts detected in these samples."""

    block: Block
    contacts: tuple[Contact, ...]
    withdrawn: Contact | None = None


@dataclass(frozen=True, slots=True)
class ClosingEnded:
    """Event: a closing ended, because the motor rests, samples are missing or a new epoch began."""

    #: First sample after the closing.
    sample: int
    epoch: int
    is_complete: bool


ClosingEvent = ClosingBegan | ClosingSamples | ClosingEnded


_log = logging.getLogger("firstcontact.contact")


class Closings:
    """Splitter that divides a stream into closings of the hand, and detects contacts in each."""

    def __init__(
        self, layout: Layout, detector: Detector, calibration: Calibration | None = None
    ) -> None:
        self._layout = layout
        self._chain = contact_chain(detector, layout, calibration)
        self._first: Contact | None = None
        self._open = False
        self._epoch = 0

    def update(self, block: Block) -> Iterator[ClosingEvent]:
        """Process the next block of samples. Yield the events in it, in time order."""
        events = self._chain.take(block)
        # Until a closing begins, events belong to the epoch of the closing before.
        epoch, self._epoch = self._epoch, block.epoch
        position = block.first_sample
        contacts: tuple[Contact, ...] = ()
        for event in events:
            match event.kind:
                case EventKind.CLOSING_BEGAN:
                    self._open, self._first = True, None
                    position, epoch = event.sample, block.epoch
                    yield ClosingBegan(event.sample, block.epoch)
                case EventKind.CONTACT_FOUND:
                    contact = contact_of(event, self._layout)
                    self._first = self._first or contact
                    contacts = (*contacts, contact)
                case EventKind.CONTACT_WITHDRAWN:
                    _log.info("the contact at sample %d is withdrawn", event.sample)
                    piece = _cut(block, position, event.known + 1)
                    yield ClosingSamples(piece, contacts, self._first)
                    position, contacts, self._first = event.known + 1, (), None
                case EventKind.CLOSING_ENDED:
                    is_complete = event.reason != Reason.LOST
                    if is_complete:
                        yield ClosingSamples(_cut(block, position, event.sample), contacts)
                        position = event.sample
                    contacts, self._open = (), False
                    yield ClosingEnded(event.sample, epoch, is_complete)
        if self._open and position < block.end:
            yield ClosingSamples(_cut(block, position, block.end), contacts)


def _cut(block: Block, start: int, stop: int) -> Block:
    first = block.first_sample
    return Block(block.data[start - first : stop - first], start, block.epoch)
