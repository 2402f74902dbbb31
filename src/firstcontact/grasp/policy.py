"""Base class of grasp policies, with the types of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING, ClassVar

from firstcontact.core import Command
from firstcontact.core.display import SKY
from firstcontact.grasp._grip import Grip

if TYPE_CHECKING:
    from firstcontact.core import Contact, Estimate


@dataclass(frozen=True, slots=True)
class Truth:
    """True properties of an object. Only a simulation knows them before the hand closes."""

    #: Stiffness, Shore A.
    shore_a: float
    #: Mass, kg.
    mass: float = 0.2


class Task(Enum):
    """Task that a policy is made for. Only policies with the same task are compared."""

    #: Hold a declared payload, as gently and as early as possible.
    PAYLOAD = auto()
    #: Hold household objects of unknown weight without breaking them.
    HOUSEHOLD = auto()


class PolicyRole(Enum):
    """Role of a policy in a comparison: baseline or candidate, for example."""

    #: Today's method, which a candidate must beat.
    BASELINE = auto()
    #: Compared with every baseline.
    CANDIDATE = auto()
    #: Upper limit that uses knowledge no real hand has.
    LIMIT = auto()


@dataclass(frozen=True, slots=True)
class Tunable:
    """Setting of a policy that the grasp study tunes, and the values to try.

    Its name is that of a parameter of the policy's class.
    """

    title: str
    unit: str
    scale: float
    tried: tuple[float, ...]
    few: tuple[float, ...]


class Policy:
    """Base class of grasp policies, which set a closing hand's speed and force limit.

    Subclasses override the methods for the events that they react to. Each method returns a
    command, which holds until the next one, or None to keep the current command. Without
    overridden methods, the hand closes with ``grip.approach`` to the end.

    Parameters
    ----------
    grip
        Properties of the hand and its payload.

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

    #: Name in the registry and in reports; by default that of the class.
    name: ClassVar[str]
    #: Title in tables and figures.
    title: ClassVar[str]
    #: Colour in figures, such as "#56B4E9".
    colour: ClassVar[str] = SKY
    #: Role of the policy in comparisons, and the task that it solves.
    part: ClassVar[PolicyRole] = PolicyRole.CANDIDATE
    task: ClassVar[Task] = Task.PAYLOAD
    #: True if the constructor takes a :class:`Truth` after the grip. No real hand can give one.
    needs_truth: ClassVar[bool] = False
    #: Settings that a study tunes before it compares policies, by parameter of the constructor.
    tunables: ClassVar[Mapping[str, Tunable]] = {}
    #: Time after the first contact at which :meth:`late` is called if no estimate came, s.
    #: None if the policy uses no estimates.
    deadline: float | None = None

    def __init_subclass__(cls) -> None:
        if not hasattr(cls, "name"):
            cls.name = cls.__name__

    def __init__(self, grip: Grip) -> None:
        self.grip = grip

    @classmethod
    def uses_piezos(cls) -> bool:
        """Return True if the policy reacts to contacts or estimates, which come from the piezos."""
        return (cls.touched, cls.estimated) != (Policy.touched, Policy.estimated)

    @classmethod
    def has_reflex(cls) -> bool:
        """Return True if the policy reacts to slips of the held object."""
        return cls.slipped is not Policy.slipped

    def begin(self) -> Command:
        """Return the command with which a closing begins."""
        return self.grip.approach

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """React to a finger's contact. ``first`` is True for the first contact of a closing."""
        return None

    def estimated(self, estimate: Estimate) -> Command | None:
        """React to a stiffness estimate. It replaces earlier estimates of the same contact.

        The final estimate is passed again only if it differs from the newest one.
        """
        return None

    def felt(self, volts: float, since: float | None) -> Command | None:
        """React to the force sensors. This method is called for every block of samples.

        ``volts`` is the largest rise of any force cell's voltage above its unloaded level, V.
        ``since`` is the time since the first contact, s; None before it.
        """
        return None

    def slipped(self) -> Command | None:
        """React to a slip of the held object. This method is called repeatedly during a slip."""
        return None

    def late(self) -> Command | None:
        """React to a missing estimate. Return the command to use without one.

        This method is called if the deadline passed without an estimate. It is also called if the
        newest estimate cannot be used: it is out of range, or its samples are from after the second
        contact.
        """
        return None
