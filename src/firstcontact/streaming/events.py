"""Live events: structs that are also written as JSON lines and sent to the page."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from firstcontact.core import ClosingSpeed, Contact
from firstcontact.core import Estimate as Estimate
from firstcontact.recording import PinchMark


class Ask(StrEnum):
    """Request to a hand."""

    CLOSE = "close"
    OPEN = "open"


class Verdict(StrEnum):
    """Availability of an estimate at the second contact of a pinch.

    Examples
    --------
    >>> import firstcontact as fc
    >>> [str(verdict) for verdict in fc.Verdict]
    ['in_time', 'too_late', 'none']
    """

    IN_TIME = "in_time"
    TOO_LATE = "too_late"
    NONE = "none"


class _Reported(msgspec.Struct, frozen=True):
    @property
    def known_sample(self) -> int:
        """Number of the last sample that was needed to report this event."""
        match self:
            case ContactEvent():
                return self.contact.decided
            case ContactWithdrawn() | NoEstimate():
                return self.complete
            case PinchDone() | ObjectEstimate():
                return self.end - 1
            case HandPrediction():
                return self.event.known_sample
        return int(self.sample)  # type: ignore[attr-defined]


class ClosingStart(_Reported, frozen=True, tag="closing_start"):
    """Start of a closing. Contacts are reported from this sample on.

    Parameters
    ----------
    sample, epoch
        Number and epoch of the first sample of the closing.
    """

    sample: int
    epoch: int


class ContactEvent(_Reported, frozen=True, tag="contact"):
    """Contact of one finger.

    Parameters
    ----------
    contact
        Contact with three fields: the finger (0 index finger, 1 thumb, null for a sensor of no
        finger), the sample of the contact, and the sample after which it was detected.
    first
        True for the first contact of the closing.
    epoch
        Epoch of the samples.
    host
        Time at which the host detected the contact, s of its monotonic clock.
    """

    contact: Contact
    first: bool
    epoch: int
    host: float


class ContactWithdrawn(_Reported, frozen=True, tag="contact_withdrawn"):
    """Withdrawal of a first contact, whose signal turned out to be a click of the gears.

    The contact, all later contacts and all estimates of the closing so far are invalid. The closing
    continues, and its true contact may follow.

    Parameters
    ----------
    contact
        Withdrawn contact.
    complete
        Number of the last sample that was needed to withdraw the contact.
    epoch
        Epoch of the samples.
    """

    contact: Contact
    complete: int
    epoch: int


class NoEstimate(_Reported, frozen=True, tag="no_estimate"):
    """Report that a closing has no valid estimate, with the reason.

    Parameters
    ----------
    contact
        First contact of the closing.
    reason
        Reason in a few words.
    complete
        Number of the last sample that was needed to report this.
    epoch
        Epoch of the samples.
    """

    contact: Contact
    reason: str
    complete: int
    epoch: int


def judged(estimate: Estimate, offset: float | None, *, real_time: bool = True) -> Estimate:
    in_time = (offset is None or estimate.available < offset) if real_time else None
    if in_time is estimate.in_time:
        return estimate
    return msgspec.structs.replace(estimate, in_time=in_time)


class PinchDone(_Reported, frozen=True, kw_only=True, tag="pinch"):
    """Finished closing with all its contacts and estimates.

    Parameters
    ----------
    number
        Number of the pinch, from 1. Closings without a contact are not counted.
    start, end
        Number of the pinch's first sample, and of the first sample after the pinch.
    epoch
        Epoch of the pinch's samples.
    contacts
        Detected contacts: the first, and the second if there was one.
    strips
        Contacts by the contact strips of the fingers; empty without strips.
    offset
        Time from the first to the second contact, s; null without a second contact.
    estimates
        Estimates from samples before the second contact, with ``in_time``; the last one is final.
    reason
        Reason for a missing estimate; empty if there is one.
    real_time
        True if samples came as fast as they were taken.
    closing_speed
        Closing speed before the first contact and its standard error, m/s, as the hand measured
        them; null if not measured.
    verdict
        ``in_time`` if an estimate was in time, ``too_late`` if all estimates were too late,
        ``none`` if there was no estimate. Null if there is an estimate but samples did not come in
        real time. The verdict follows from the other fields.
    delay_cause
        Cause of a delay without which an estimate would have been in time, in words: this computer,
        another output of the program, or the device. Empty if there was no such delay.
    """

    number: int
    start: int
    end: int
    epoch: int
    contacts: tuple[Contact, ...]
    strips: tuple[Contact, ...] = ()
    offset: float | None = None
    estimates: tuple[Estimate, ...] = ()
    reason: str = ""
    real_time: bool = True
    closing_speed: ClosingSpeed | None = None
    verdict: Verdict | None = None
    delay_cause: str = ""

    def __post_init__(self) -> None:
        estimates = tuple(judged(e, self.offset, real_time=self.real_time) for e in self.estimates)
        verdict: Verdict | None = None
        if not estimates:
            verdict = Verdict.NONE
        elif self.real_time:
            early = any(e.in_time for e in estimates)
            verdict = Verdict.IN_TIME if early else Verdict.TOO_LATE
        msgspec.structs.force_setattr(self, "estimates", estimates)
        msgspec.structs.force_setattr(self, "verdict", verdict)

    @property
    def final(self) -> Estimate | None:
        """Last estimate, however late it was; None if there is none."""
        return self.estimates[-1] if self.estimates else None

    @property
    def in_force(self) -> Estimate | None:
        """Last estimate that was in time; the final one if samples did not come in real time."""
        if not self.real_time:
            return self.final
        return next((e for e in reversed(self.estimates) if e.in_time), None)

    @property
    def second(self) -> Contact | None:
        """Second contact; None if there is none."""
        return self.contacts[1] if len(self.contacts) > 1 else None

    def holds(self, epoch: int, sample: int) -> bool:
        """Return True if a sample lies in the pinch."""
        return epoch == self.epoch and self.start <= sample < self.end

    def overlaps(self, mark: PinchMark) -> bool:
        """Return True if a pinch of a recording shares a sample with this pinch."""
        return mark.epoch == self.epoch and mark.first_sample < self.end and self.start < mark.end


class ObjectEstimate(_Reported, frozen=True, kw_only=True, tag="object_estimate"):
    """Pooled estimate from all pinches of one object so far.

    Parameters
    ----------
    number
        Number of the last pinch.
    value
        Shore A.
    low, high
        Ends of the interval.
    level
        Nominal coverage: share of intervals that should contain the true value. It holds for
        contacts that are like the training data.
    pinches
        Number of pooled pinches; 1 for the first pinch of an object.
    is_named
        True if the object was marked, so that its next pinches are pooled with this one.
    end
        Number of the first sample after the last pinch.
    epoch
        Epoch of the samples.
    """

    number: int
    value: float
    low: float
    high: float
    level: float
    pinches: int
    is_named: bool = True
    end: int
    epoch: int


class HandCommand(_Reported, frozen=True, tag="hand_command"):
    """Request that the driven hand carried out, or release of the hand without a request.

    Parameters
    ----------
    ask
        ``close`` or ``open``.
    by
        Origin: ``keyboard``, ``standard input``, ``viewer N of the page`` or the name of another
        program. ``silence`` for a release because samples stopped coming or this program paused.
    sample, epoch
        Newest sample at the time of the request or release, and its epoch.
    """

    ask: Ask
    by: str
    sample: int
    epoch: int


class HandPrediction(_Reported, frozen=True, tag="hand_prediction"):
    """Contact or estimate of a device that predicts by itself.

    Parameters
    ----------
    event
        The device's ``contact``, ``contact_withdrawn``, ``estimate`` or ``no_estimate``. Its
        ``host`` is the time at which the host received it. Its ``compute`` is the computing time on
        the device, 0 if the device does not measure this time.
    """

    event: ContactEvent | ContactWithdrawn | Estimate | NoEstimate

    @property
    def epoch(self) -> int:
        """Epoch of the samples."""
        return self.event.epoch


class HandCheck(msgspec.Struct, frozen=True, kw_only=True):
    """Comparison of the predictions of device and host for one pinch.

    Parameters
    ----------
    same
        True if contacts, estimates and intervals of the device equal those of the host.
    compared
        Number of compared estimates.
    lost
        True if the host lost samples of the pinch.
    """

    same: bool
    compared: int
    lost: bool = False


class HandPinch(_Reported, frozen=True, kw_only=True, tag="hand_pinch"):
    """Predictions of a device for one pinch; the event follows 0.3 s after the first contact.

    Parameters
    ----------
    number
        Number of the pinch, from 1.
    model
        Digest of the device's model.
    contacts
        Contacts that the device detected; empty if only the host detected the pinch.
    final
        Last estimate from samples before the second contact; null without one.
    estimates
        Number of estimates from samples before the second contact.
    check
        Comparison with the host's own model; null without a model on the host.
    sample, epoch
        Sample and epoch of the first contact, as detected by the device or else by the host.
    """

    number: int
    model: str
    contacts: tuple[Contact, ...]
    final: Estimate | None
    estimates: int
    check: HandCheck | None
    sample: int
    epoch: int


Event = (
    ClosingStart
    | ContactEvent
    | ContactWithdrawn
    | Estimate
    | NoEstimate
    | PinchDone
    | ObjectEstimate
    | HandCommand
    | HandPrediction
    | HandPinch
)
