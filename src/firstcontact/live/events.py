"""What the live pipeline says, as it happens."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from firstcontact.core import Contact, Finger
from firstcontact.device.told import Told, ToldContact, ToldEstimate
from firstcontact.live.hand_requests import Ask
from firstcontact.recording import PinchMark


class Case(StrEnum):
    """Whether an estimate came in time to be acted upon."""

    IN_TIME = "before the second contact"
    TOO_LATE = "after the second contact"


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

    def after(self, rate: float) -> float:
        """From the contact to the answer, s, without the way through the cable; rate in Hz."""
        return (self.complete - self.contact.sample) / rate + self.waited + self.compute


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimated(Answer):
    """What a model of a fixed window says, once.

    Parameters
    ----------
    case
        Whether the second finger was known to touch by then, told by the samples
        up to ``complete``. In hindsight see :attr:`PinchDone.cases`.
    used
        Whether it may be acted upon: it came in time, as far as was known.
    """

    case: Case
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
    cases
        Of each estimate, in hindsight: whether it was out, its waiting and computation
        included, before the second contact happened. A contact is decided a little
        after it happens; an estimate between the two was acted upon too late.
    refused
        Why there is none, or "".
    answers
        Of the any-time model, from samples before the second contact.
    out
        How many of these were out, in hindsight, before the second contact happened.
    """

    number: int
    armed: int
    end: int
    epoch: int
    contacts: tuple[Contact, ...]
    strips: tuple[tuple[Finger, int], ...]
    estimates: tuple[Estimated, ...]
    cases: tuple[Case, ...] = ()
    refused: str = ""
    answers: tuple[Running, ...] = ()
    out: int = 0

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
    def standing_case(self) -> Case | None:
        """Of the standing answer, in hindsight; None without one."""
        if not self.answers:
            return None
        return Case.IN_TIME if self.out == len(self.answers) else Case.TOO_LATE


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

    told: Told
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
    first: ToldContact | None
    second: ToldContact | None
    standing: ToldEstimate | None
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
