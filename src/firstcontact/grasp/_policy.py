"""What a grasp policy is: from what is known of a pinch to what the hand should do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING, ClassVar

from firstcontact.core import SKY, Command
from firstcontact.grasp._grip import Grip

if TYPE_CHECKING:
    from firstcontact.core import Contact


@dataclass(frozen=True, slots=True)
class Stiffness:
    """An estimate as a policy sees it: one that the second finger has not overtaken.

    Parameters
    ----------
    value
        Shore A.
    low, high
        Bounds of the interval; equal to the value where the model has none.
    duration
        Of the window it was made from, s.
    standing
        Whether no better one comes, however short its window was.
    """

    value: float
    low: float
    high: float
    duration: float
    standing: bool = False


@dataclass(frozen=True, slots=True)
class Truth:
    """What a policy that no real hand can be driven with is told of the object beforehand.

    Parameters
    ----------
    shore_a
        Shore A.
    mass
        kg.
    """

    shore_a: float
    mass: float = 0.2


class Task(Enum):
    """What a policy is for, and compared in."""

    #: Hold a declared payload, as gently and as soon as can be.
    PAYLOAD = auto()
    #: Hold whatever people pick up, of a weight that nobody declares, and break nothing.
    HOUSEHOLD = auto()


class Part(Enum):
    """What part a policy has in a comparison."""

    #: Modulates nothing; what is tuned may take hardly longer.
    UNMODULATED = auto()
    #: What there is today, to be beaten.
    BASELINE = auto()
    #: Does as the candidates do, but knows no stiffness.
    CONTROL = auto()
    #: Is judged against every baseline and control.
    CANDIDATE = auto()
    #: Shows what could be reached at most.
    LIMIT = auto()


class ForceArray(Enum):
    """The force sensors that a policy is tried with on the twin."""

    #: As they are drawn for each pinch.
    DRAWN = auto()
    #: The best that such a sensor could be.
    IDEAL = auto()


@dataclass(frozen=True, slots=True)
class SensorVariant:
    """A policy with one kind of force sensors.

    Parameters
    ----------
    key
        In tables and files.
    title, colour
        As of a policy.
    force_array
        What it feels with.
    """

    key: str
    title: str
    colour: str
    force_array: ForceArray = ForceArray.DRAWN


@dataclass(frozen=True, slots=True)
class Tunable:
    """A setting of a policy that a study chooses; a keyword of the policy.

    Parameters
    ----------
    title, unit, scale
        As a table shows it, and what the value is multiplied by for that.
    tried, few
        Values to choose from; fewer of them in a quick study.
    """

    title: str
    unit: str
    scale: float
    tried: tuple[float, ...]
    few: tuple[float, ...]


class Policy:
    """Decides what a hand does in one closing after the other.

    This one closes as it began, whatever happens: others say what they do besides. Each
    method may answer with a command, which holds until the next, or with None to leave
    things as they are.

    Parameters
    ----------
    grip
        What is declared of the hand.

    Examples
    --------
    >>> class Slow(Policy):
    ...     name, title = "slow", "half the speed"
    ...
    ...     def begin(self):
    ...         return Command(self.grip.speed / 2, self.grip.approach.force)
    >>> Slow(Grip(speed=0.1)).begin().speed
    0.05
    """

    #: Under which it is registered and reported.
    name: ClassVar[str]
    #: As people read it.
    title: ClassVar[str]
    #: In figures, of the form "#56B4E9".
    colour: ClassVar[str] = SKY
    part: ClassVar[Part] = Part.CANDIDATE
    task: ClassVar[Task] = Task.PAYLOAD
    #: Whether it is told a :class:`Truth`, behind the grip: no real hand can be driven so.
    needs_truth: ClassVar[bool] = False
    #: What a study tunes before it compares.
    tunables: ClassVar[Mapping[str, Tunable]] = {}
    #: With which sensors a study tries it, if not just as it is.
    variants: ClassVar[tuple[SensorVariant, ...]] = ()
    #: Time after the first contact by which it wants an estimate, s; None if it wants none.
    deadline: float | None = None

    def __init__(self, grip: Grip) -> None:
        self.grip = grip

    @classmethod
    def hears(cls) -> bool:
        """Whether it acts on what the piezos tell: contacts or estimates."""
        return (cls.touched, cls.estimated) != (Policy.touched, Policy.estimated)

    @classmethod
    def feels(cls) -> bool:
        """Whether it acts on the force sensors."""
        return cls.felt is not Policy.felt

    @classmethod
    def has_reflex(cls) -> bool:
        """Whether it acts when the object slips."""
        return cls.slipped is not Policy.slipped

    def begin(self) -> Command:
        """A closing begins: at the approach's speed, no stronger than that needs."""
        return self.grip.approach

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """A finger touched; ``first`` says whether it is the first of this closing."""
        return None

    def estimated(self, stiffness: Stiffness) -> Command | None:
        """An estimate came."""
        return None

    def felt(self, volts: float, since: float | None) -> Command | None:
        """The loudest taxel is this far above its unloaded level, V, so long after the contact, s.

        Asked with every block of samples; ``since`` is None before the first contact.
        """
        return None

    def slipped(self) -> Command | None:
        """The object slips, as a detector says; told again while it goes on slipping."""
        return None

    def late(self) -> Command | None:
        """The deadline passed without an estimate: the declared fallback."""
        return None
