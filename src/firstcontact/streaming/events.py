"""Live events: records that are also written as JSON lines and sent to the page."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from firstcontact.core import ClosingSpeed, Contact
from firstcontact.core import Estimate as Estimate
from firstcontact.recording import PinchMark


class Ask(StrEnum):
    """Request to the hand: to close or to open."""

    CLOSE = "close"
    OPEN = "open"


class Verdict(StrEnum):
    """Rating of a pinch by the time of its estimates, relative to the second finger's contact.

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
        """Number of the last sample that had to arrive before this event could be reported."""
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
    """Start of a closing of the hand: its motor runs. Contacts can be reported from this sample on.

    Parameters
    ----------
    sample, epoch
        Number of the first sample of the closing, and epoch (run of the device's sample counter).
    """

    sample: int
    epoch: int


class ContactEvent(_Reported, frozen=True, tag="contact"):
    """Detected contact: one finger has touched the object.

    Parameters
    ----------
    contact
        ``finger`` (0 index finger, 1 thumb, null if the sensor is on no finger), number of the
        ``sample`` at which it touched, and ``decided``, the last sample that the detector needed.
    first
        True if this is the first contact of the closing.
    epoch
        Epoch (run of the device's sample counter) of the samples.
    host
        Time at which the contact was detected, s of this computer's ``time.monotonic()``.
    """

    contact: Contact
    first: bool
    epoch: int
    host: float


class ContactWithdrawn(_Reported, frozen=True, tag="contact_withdrawn"):
    """Cancellation of a first contact: later samples show that it was a click of the gears.

    All contacts and estimates of the closing so far are invalid. The closing continues, and its
    true contact may follow.

    Parameters
    ----------
    contact
        First contact of the closing, now cancelled.
    complete
        Number of the last sample that was needed to cancel the contact.
    epoch
        Epoch (run of the device's sample counter) of the samples.
    """

    contact: Contact
    complete: int
    epoch: int


class NoEstimate(_Reported, frozen=True, tag="no_estimate"):
    """Report that a closing with a contact gets no valid stiffness estimate.

    Parameters
    ----------
    contact
        First contact of the closing.
    reason
        Reason in a few words, such as "samples were lost".
    complete
        Number of the last sample that was needed to report this.
    epoch
        Epoch (run of the device's sample counter) of the samples.
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
    """End of a pinch: one closing of the hand, with all of its contacts and estimates.

    Parameters
    ----------
    number
        Number of the pinch in this session, from 1. Closings without a contact are not counted.
    start, end
        Number of the pinch's first sample, and of the first sample after the pinch.
    epoch
        Epoch (run of the device's sample counter) of the samples.
    contacts
        Detected contacts: the first finger's, and the second finger's if it was detected.
    strips
        True contacts, measured by copper strips on the fingers; empty for a hand without strips.
    offset
        Time from the first to the second contact, s; null without a second contact.
    estimates
        Estimates from samples before the second contact, in order; the last one is final.
    reason
        Reason why there is no estimate; empty if there is one.
    real_time
        True if samples arrived in real time, as from a device; False in a fast replay.
    closing_speed
        Speed of the closing hand just before the first contact, and standard error of this speed,
        both m/s; null if the hand does not measure it.
    verdict
        ``in_time`` if an estimate was available before the second contact, ``too_late`` if all came
        later, ``none`` if there was none. Null if there is an estimate but samples did not arrive
        in real time. It is computed from the other fields.
    delay_cause
        Cause in words, if a delay alone made all estimates too late: this computer, another output
        of the program, or the device. Otherwise empty.
    hand_used
        True if a command that follows from an estimate reached the hand before the second contact.
        False if none did. Null without a hand, and for a policy that uses no estimates.
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
    hand_used: bool | None = None

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
        """Last estimate of the pinch, even if it was too late; None without an estimate."""
        return self.estimates[-1] if self.estimates else None

    @property
    def in_force(self) -> Estimate | None:
        """Last estimate that was available before the second finger's contact; None if none was.

        If samples did not arrive in real time, it is the last estimate.
        """
        if not self.real_time:
            return self.final
        return next((e for e in reversed(self.estimates) if e.in_time), None)

    @property
    def second(self) -> Contact | None:
        """Contact of the second finger; None if no such contact was detected."""
        return self.contacts[1] if len(self.contacts) > 1 else None

    def holds(self, epoch: int, sample: int) -> bool:
        """Return True if the pinch contains this sample of this epoch."""
        return epoch == self.epoch and self.start <= sample < self.end

    def overlaps(self, mark: PinchMark) -> bool:
        """Return True if ``mark``, a pinch marked in a recording, shares samples with this one."""
        return mark.epoch == self.epoch and mark.first_sample < self.end and self.start < mark.end


class ObjectEstimate(_Reported, frozen=True, kw_only=True, tag="object_estimate"):
    """Stiffness averaged over all pinches of one object so far.

    Parameters
    ----------
    number
        Number of the last averaged pinch.
    value
        Estimated Shore A hardness, 0 to 100.
    low, high
        Ends of the interval around ``value``, Shore A.
    level
        Nominal coverage: share of intervals that should contain the true value. It holds for
        contacts that are like the training data.
    pinches
        Number of averaged pinches; 1 for the first pinch of an object.
    is_named
        True if a marker or label identifies the object: its next pinches are averaged with this.
    end
        Number of the first sample after the last averaged pinch.
    epoch
        Epoch (run of the device's sample counter) of the samples.
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
    """Command that the hand carried out: a request to close or open, or a safety release.

    Parameters
    ----------
    ask
        ``close`` or ``open``.
    by
        Origin: ``keyboard``, ``standard input``, ``viewer N of the page`` or the name of another
        program. ``silence`` for a release because samples stopped arriving or this program paused.
    sample, epoch
        Number of the newest sample at the time of the command, and its epoch.
    """

    ask: Ask
    by: str
    sample: int
    epoch: int


class PolicyCommand(_Reported, frozen=True, tag="policy_command"):
    """Command of the grasp policy that was passed to the hand: speed and force of the fingertips.

    The hand holds it until the next command, or until a ``hand_command`` opens it.

    Parameters
    ----------
    speed
        Speed at which each fingertip closes, m/s. A negative speed opens the hand, 0 stops it.
    force
        Upper limit on the force of each fingertip, N.
    sample, epoch
        Number of the newest sample at the time of the command, and its epoch.
    """

    speed: float
    force: float
    sample: int
    epoch: int


class HandPrediction(_Reported, frozen=True, tag="hand_prediction"):
    """Contact or estimate from a device that runs a model itself, such as a hand.

    Parameters
    ----------
    event
        The device's ``contact``, ``contact_withdrawn``, ``estimate`` or ``no_estimate``. Its field
        ``host`` is the time at which this computer received it. Its field ``compute`` is the
        computing time on the device, s; 0 if the device does not measure it.
    """

    event: ContactEvent | ContactWithdrawn | Estimate | NoEstimate

    @property
    def epoch(self) -> int:
        """Epoch (run of the device's sample counter) of the samples."""
        return self.event.epoch


class HandCheck(msgspec.Struct, frozen=True, kw_only=True):
    """Comparison of the predictions of a device and of this computer (the host) for one pinch.

    Parameters
    ----------
    same
        True if the device's contacts, estimates and intervals equal those of the host.
    compared
        Number of estimates that were compared.
    lost
        True if the host did not receive all samples of the pinch.
    """

    same: bool
    compared: int
    lost: bool = False


class HandPinch(_Reported, frozen=True, kw_only=True, tag="hand_pinch"):
    """Predictions of a device's own model for one pinch, reported 0.3 s after the first contact.

    Parameters
    ----------
    number
        Number of the pinch in this session, from 1.
    model
        Digest (hash) that identifies the device's model.
    contacts
        Contacts that the device detected; empty if only this computer detected the pinch.
    final
        Device's last estimate from samples before the second contact; null without one.
    estimates
        Number of the device's estimates from samples before the second contact.
    check
        Comparison with a model on this computer; null if this computer runs no model.
    sample, epoch
        Sample number and epoch of the first contact that the device, or else the host, detected.
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
    | PolicyCommand
    | HandPrediction
    | HandPinch
)
