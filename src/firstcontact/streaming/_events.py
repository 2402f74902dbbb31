"""What the live pipeline says, as it happens."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from firstcontact.core import Contact, Finger
from firstcontact.device import DeviceContact, DeviceEstimate, DevicePrediction
from firstcontact.recording import PinchMark
from firstcontact.streaming._hand_requests import Ask


class Case(StrEnum):
    """Availability of an estimate at the second contact, as :func:`is_in_time` decides it."""

    IN_TIME = "in time"
    TOO_LATE = "too late"
    NONE = "no estimate"


@dataclass(frozen=True, slots=True)
class Armed:
    """A closing began: from here on contacts count."""

    sample: int
    epoch: int


@dataclass(frozen=True, slots=True)
class Touched:
    """A finger touched.

    ``first`` says whether it is the closing's first; ``host`` is when that was
    known (monotonic, s); sample numbers are in ``contact``.
    """

    contact: Contact
    first: bool
    epoch: int
    host: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """How stiff what the first finger touched is, as a model says.

    Parameters
    ----------
    contact
        The first contact.
    value
        Shore A, or the class.
    low, high
        Bounds of the interval; equal to the value where the model has none.
    level
        Share of intervals that are to hold the truth; 0 without one.
    duration
        Of the signal after the contact that it was made from, s.
    complete
        Number of the sample with which that and the contact were both known.
    epoch
        Of the samples.
    host
        When it came (monotonic, s).
    compute
        From having the block that completed it to the answer, s.
    waited
        How long that sample waited for the rest of its block, by the device's clock, s.
    transport
        How much later that block reached the host than the least delayed of the last ten
        seconds, s. The shortest way through the cable is not known and is not in it.
    """

    contact: Contact
    value: float
    low: float
    high: float
    level: float
    duration: float
    complete: int
    epoch: int
    host: float
    compute: float
    waited: float = 0.0
    transport: float = 0.0

    def after(self, rate: float) -> float:
        """Return the time from the contact until the answer was available, s; rate in Hz.

        Signal, waiting, transport and computing are in it: it is the difference of two instants
        on the host's clock, on which the least delayed blocks place each sample.
        """
        signal = (self.complete - self.contact.sample) / rate
        return signal + self.waited + self.transport + self.compute


def is_in_time(answer: Answer, second: Contact | None, rate: float) -> bool:
    """Return True if an estimate was available before the second contact.

    This is what "in time" means in all live output. Both instants count from the first contact on
    the host's clock: the estimate's with waiting, transport and computing, the second contact's as
    its sample was taken. Without a second contact nothing can be too late.

    Parameters
    ----------
    answer
        The estimate.
    second
        The second contact of its pinch; None where none was heard.
    rate
        Of the samples, Hz.
    """
    if second is None:
        return True
    return answer.after(rate) < (second.sample - answer.contact.sample) / rate


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimated(Answer):
    """What a model of a fixed window says, once.

    Parameters
    ----------
    used
        Whether a hand may act upon it: no second contact was known by sample ``complete``. A
        contact is known a little after it happens, so this says less than "in time" does.
    """

    used: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Running(Answer):
    """What an any-time model knows so far, each millisecond from 2 ms after the contact on.

    Parameters
    ----------
    half_width
        Of the interval, before it was cut off at the ends of the scale.
    strange
        Whether the contact is out of range: like nothing that was learned from, so that the
        interval may not hold.
    samples
        That it was made from, after the contact.
    radius
        Of the thing, m, as somebody told it: infinite for a flat one, None where nobody did.
    """

    half_width: float
    strange: bool
    samples: int
    radius: float | None = None


@dataclass(frozen=True, slots=True)
class Settled:
    """No better answer comes: second contact, longest time over, or the closing ended before.

    Every closing with a contact has one where an any-time model is asked.

    A second contact is decided a little after it happens. Answers that were made from samples
    after it are withdrawn then: so this may come twice in a closing, and the later one counts.

    Parameters
    ----------
    contact
        The first contact.
    answer
        The one that stands: the last from samples before the second contact. None where there
        is none.
    withdrawn
        Answers that were told and do not count.
    complete
        Number of the sample with which this was known.
    epoch
        Of the samples.
    reason
        Why there is no answer, "" where there is one.
    """

    contact: Contact
    answer: Running | None
    withdrawn: int
    complete: int
    epoch: int
    reason: str = ""


@dataclass(frozen=True, slots=True)
class SameObject:
    """What all pinches of the object so far say together.

    A pinch of an object that nobody told of stands by itself.

    Parameters
    ----------
    number
        Of the last pinch.
    value
        Shore A.
    low, high
        Bounds of the interval.
    level
        Share of intervals that are to hold the truth.
    pinches
        How many it is made from; 1 where the object is a new one, or not known.
    end
        One past the last sample of the last pinch.
    epoch
        Of the samples.
    told
        Whether somebody told of the object, so that its pinches are combined.
    """

    number: int
    value: float
    low: float
    high: float
    level: float
    pinches: int
    end: int
    epoch: int
    told: bool = True


@dataclass(frozen=True, slots=True)
class Refused:
    """A closing that there is no answer about, and why, in a few words."""

    contact: Contact
    reason: str
    epoch: int


@dataclass(frozen=True, slots=True)
class PinchDone:
    """A closing is over: all that was found in it.

    Parameters
    ----------
    number
        Counts closings with a contact from 1.
    armed
        Sample from which contacts counted.
    end
        One past the last sample that belongs to it.
    epoch
        Of these samples.
    contacts
        As detected: the first, and the second where there was one.
    strips
        As the strips say, where there are strips: sample of each finger.
    estimates
        In the order of their windows.
    rate
        Of the samples, Hz.
    refused
        Why there is none, or "".
    answers
        Of the any-time model, from samples before the second contact.
    real_time
        Whether samples came as fast as they were taken. Where not, nothing is known of what
        would have been in time.
    """

    number: int
    armed: int
    end: int
    epoch: int
    contacts: tuple[Contact, ...]
    strips: tuple[tuple[Finger, int], ...]
    estimates: tuple[Estimated, ...]
    rate: float
    refused: str = ""
    answers: tuple[Running, ...] = ()
    real_time: bool = True

    def holds(self, epoch: int, sample: int) -> bool:
        """Whether a sample is one of it."""
        return epoch == self.epoch and self.armed <= sample < self.end

    def overlaps(self, mark: PinchMark) -> bool:
        """Whether a pinch of a recording shares a sample with it."""
        return mark.epoch == self.epoch and mark.first_sample < self.end and self.armed < mark.end

    @property
    def standing(self) -> Running | None:
        """The last answer from samples before the second contact."""
        return self.answers[-1] if self.answers else None

    @property
    def second(self) -> Contact | None:
        """The second contact; None where none was heard."""
        return self.contacts[1] if len(self.contacts) > 1 else None

    @property
    def offset(self) -> float | None:
        """From the first to the second contact, s; None where none was heard."""
        second = self.second
        return None if second is None else (second.sample - self.contacts[0].sample) / self.rate

    @property
    def _ordered(self) -> tuple[Running | Estimated, ...]:
        """All estimates; those of the any-time model come last, as they are preferred."""
        return (*self.estimates, *self.answers)

    @property
    def final(self) -> Running | Estimated | None:
        """The last estimate, however late it was; None without one."""
        return self._ordered[-1] if self._ordered else None

    @property
    def available(self) -> Running | Estimated | None:
        """The last estimate that was available before the second contact.

        One of the any-time model, or else of a fixed window. None where none was in time, and
        where that is not known.
        """
        if not self.real_time:
            return None
        early = [e for e in self._ordered if self.case_of(e) is Case.IN_TIME]
        return early[-1] if early else None

    @property
    def case(self) -> Case | None:
        """The pinch's one verdict; None where there is an estimate but the time means nothing."""
        if self.final is None:
            return Case.NONE
        if not self.real_time:
            return None
        return Case.TOO_LATE if self.available is None else Case.IN_TIME

    def case_of(self, answer: Answer) -> Case | None:
        """Verdict on one estimate of the pinch; None where the time means nothing."""
        if not self.real_time:
            return None
        return Case.IN_TIME if is_in_time(answer, self.second, self.rate) else Case.TOO_LATE


@dataclass(frozen=True, slots=True)
class HandAsked:
    """The hand that is driven was told to close or to open, by somebody who asked for it.

    Parameters
    ----------
    ask
        What it was told.
    by
        Who asked: "keyboard", "standard input", a viewer of the page, or "silence" where it was
        released because nothing came for too long.
    sample
        Number of the newest sample then.
    epoch
        Of that sample.
    """

    ask: Ask
    by: str
    sample: int
    epoch: int


#: Answers of the hand and of the host that differ by no more are the same, Shore A.
SAME = 0.01


@dataclass(frozen=True, slots=True)
class FromHand:
    """A contact or an estimate that a device which answers by itself told, as it came.

    Parameters
    ----------
    told
        What it told.
    host
        When it came (monotonic, s).
    """

    told: DevicePrediction
    host: float

    @property
    def epoch(self) -> int:
        """Of the samples."""
        return self.told.epoch


@dataclass(frozen=True, slots=True, kw_only=True)
class HandCheck:
    """What the device told of a pinch, held against what the host found with its own model.

    Parameters
    ----------
    contacts
        Whether the contacts are the same: fingers, samples, and when they were known.
    compared
        Answers about the same moment that both gave.
    largest
        Largest difference of a value or of an interval's end, Shore A.
    flags
        Whether both found the contact out of range, or both did not.
    missing
        Answers that only one gave, of those that the device tells.
    lost
        Whether the host could not hear it: samples of it were lost on their way.
    """

    contacts: bool
    compared: int
    largest: float
    flags: bool
    missing: int
    lost: bool = False

    @property
    def same(self) -> bool:
        """Whether nothing differs by more than 0.01 Shore A."""
        return self.contacts and self.flags and not self.missing and self.largest <= SAME


@dataclass(frozen=True, slots=True, kw_only=True)
class HandPinch:
    """All that a device which answers by itself told of a pinch.

    Parameters
    ----------
    number
        Counts them from 1.
    model
        Digest of the device's model.
    first, second
        Contacts; the first is None where only the host found the pinch.
    standing
        The last answer from samples before the second contact; None without one.
    answers
        How many of these there are.
    check
        Against the host's own; None where the host asks no model.
    sample, epoch
        Of the first contact, as the device or else the host found it.
    """

    number: int
    model: str
    first: DeviceContact | None
    second: DeviceContact | None
    standing: DeviceEstimate | None
    answers: int
    check: HandCheck | None
    sample: int
    epoch: int


Event = (
    Armed
    | Touched
    | Estimated
    | Running
    | Settled
    | Refused
    | PinchDone
    | SameObject
    | HandAsked
    | FromHand
    | HandPinch
)
