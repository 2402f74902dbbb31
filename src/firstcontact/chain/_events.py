"""Events that the C chain reports, such as a contact or an estimate."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple


class EventKind(IntEnum):
    """Kind of a :class:`ChainEvent`. The numbers equal those in ``fc_chain.h``."""

    #: The hand began to close.
    CLOSING_BEGAN = 1
    CONTACT_FOUND = 2
    #: Later samples showed that the first contact was false; its estimates are cancelled too.
    CONTACT_WITHDRAWN = 3
    ESTIMATED = 4
    #: The contact gets no estimate; ``reason`` says why.
    NOT_ESTIMATED = 5
    #: An estimate was left out, because a later one was due already.
    SKIPPED = 6
    CLOSING_ENDED = 7


class Flag(IntFlag):
    """Bit flags of a :class:`ChainEvent`, for its field ``flags``."""

    #: First contact of a closing.
    FIRST = 1
    #: No further estimate follows for this contact.
    FINAL = 2
    #: The contact is unlike the training data.
    OUT_OF_RANGE = 4


class Reason(IntEnum):
    """Reason why a closing of the hand ended, or why a contact has no estimate."""

    #: The time for estimates after the first contact is over.
    DONE = 0
    #: The motor stopped.
    RESTED = 1
    #: Samples were lost, or the device's sample counter was restarted.
    LOST = 2
    STREAM_ENDED = 3
    #: The signal before the contact is too short.
    TOO_EARLY = 4
    #: The signal of the contact is constant or not finite.
    NO_SIGNAL = 5
    #: The second finger touched before the time of the model's first estimate.
    SECOND_TOUCHED = 6
    #: The model predicted NaN or an infinite number.
    NOT_FINITE = 7


class ChainEvent(NamedTuple):
    """Event that a :class:`Chain` reports: start of a closing, contact, estimate and others.

    Parameters
    ----------
    kind, reason, flags
        Values of :class:`EventKind`, :class:`Reason` and :class:`Flag`, as integers.
    channel
        Index of the contact among the layout's vibration channels; -1 for an event without contact.
    sample
        Number of the first sample of the closing or of the contact. For CLOSING_ENDED, number of
        the first sample after the closing.
    known
        Number of the last sample that was needed to report the event.
    samples
        Number of samples after the contact that an estimate uses.
    value, low, high, half_width, spread
        Predicted Shore A hardness, ends of its interval, half the interval's width, and standard
        deviation. They are 0 for other events.
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
