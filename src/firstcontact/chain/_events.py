"""Events of the chain."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple


class EventKind(IntEnum):
    """Kind of a :class:`ChainEvent`. The numbers equal those in ``fc_chain.h``."""

    CLOSING_BEGAN = 1
    CONTACT_FOUND = 2
    CONTACT_WITHDRAWN = 3
    ESTIMATED = 4
    NOT_ESTIMATED = 5
    SKIPPED = 6
    CLOSING_ENDED = 7


class Flag(IntFlag):
    """Marks of an event, which can be combined."""

    #: First contact of a closing.
    FIRST = 1
    #: No further estimate follows for this contact.
    FINAL = 2
    OUT_OF_RANGE = 4


class Reason(IntEnum):
    """Reason why a closing ended, or why it has no estimate."""

    #: The time after the first contact is over.
    DONE = 0
    #: The motor rests.
    RESTED = 1
    #: Samples were lost, or an epoch began.
    LOST = 2
    STREAM_ENDED = 3
    #: There is too little signal before the contact.
    TOO_EARLY = 4
    #: The signal is constant or not finite.
    NO_SIGNAL = 5
    #: The second finger touched before the first moment of the model.
    SECOND_TOUCHED = 6
    NOT_FINITE = 7


class ChainEvent(NamedTuple):
    """Event in a stream, such as the start of a closing, a contact or an estimate.

    Parameters
    ----------
    kind, reason, flags
        Values of :class:`EventKind`, :class:`Reason` and :class:`Flag`.
    channel
        Position of the contact's vibration channel; -1 without a contact.
    sample
        First sample of the closing or of the contact, or the first sample after the closing.
    known
        Last sample that the event depends on.
    samples
        Number of samples after the contact that an estimate uses.
    value, low, high, half_width, spread
        Estimate with the ends of its interval, half the interval's width, and standard deviation,
        Shore A; 0 for other events.
    """

    kind: int
    reason: int
    flags: int
    channel: int
    sample: int
    known: int
    samples: int
    value: float
    low: float
    high: float
    half_width: float
    spread: float
