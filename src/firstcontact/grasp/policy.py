"""Base class of grasp policies and the types that they use."""

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
    """Properties of the object that only a simulated hand can know before it closes."""

    #: Stiffness, Shore A.
    shore_a: float
    #: Mass, kg.
    mass: float = 0.2


class Task(Enum):
    """Task of a policy. A study compares only policies with the same task."""

    #: Hold a declared payload, as gently and as early as possible.
    PAYLOAD = auto()
    #: Hold household objects of unknown weight without breaking them.
    HOUSEHOLD = auto()


class PolicyRole(Enum):
    """Role of a policy in a comparison of policies."""

    #: Today's method, which a candidate must beat.
    BASELINE = auto()
    #: Compared with every baseline.
    CANDIDATE = auto()
    #: Upper limit that uses knowledge no real hand has.
    LIMIT = auto()


@dataclass(frozen=True, slots=True)
class Tunable:
    """Setting of a policy that a study tunes. Its key is a parameter of the policy's class."""

    title: str
    unit: str
    scale: float
    tried: tuple[float, ...]
    few: tuple[float, ...]


class Policy:
    """Grasp policy: decides how a hand closes.

    This base class keeps the approach command until the end. Subclasses override the methods for
    the events that they react to. Each method returns a command, which holds until the next one, or
    None to keep the current command.

    Parameters
    ----------
    grip
        Declared properties of the hand.

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

    #: Name in the registry and in reports.
    name: ClassVar[str]
    #: Title in tables and figures.
    title: ClassVar[str]
    #: Colour in figures, such as "#56B4E9".
    colour: ClassVar[str] = SKY
    part: ClassVar[PolicyRole] = PolicyRole.CANDIDATE
    task: ClassVar[Task] = Task.PAYLOAD
    #: True if the constructor takes a :class:`Truth` after the grip. No real hand can give one.
    needs_truth: ClassVar[bool] = False
    #: Settings that a study tunes before it compares.
    tunables: ClassVar[Mapping[str, Tunable]] = {}
    #: True to receive every estimate of a contact; False to receive the final one only.
    early: ClassVar[bool] = False
    #: Latest time of an estimate after the first contact, s; None if the policy uses none.
    deadline: float | None = None

    def __init__(self, grip: Grip) -> None:
        self.grip = grip

    @classmethod
    def uses_piezos(cls) -> bool:
        """Return True if the policy reacts to contacts or estimates, which come from the piezos."""
        return (cls.touched, cls.estimated) != (Policy.touched, Policy.estimated)

    @classmethod
    def has_reflex(cls) -> bool:
        """Return True if the policy acts when the object slips."""
        return cls.slipped is not Policy.slipped

    def begin(self) -> Command:
        """Return the command at the beginning of a closing."""
        return self.grip.approach

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """React to a contact. ``first`` is True for the first contact of this closing."""
        return None

    def estimated(self, estimate: Estimate) -> Command | None:
        """React to an estimate. It was predicted from samples before the second contact only."""
        return None

    def felt(self, volts: float, since: float | None) -> Command | None:
        """React to the force sensors. The loop calls this method with every block.

        ``volts`` is the largest rise of a taxel's voltage above its unloaded level, over both
        fingers, V; ``since`` the time since the first contact, s, or None before it.
        """
        return None

    def slipped(self) -> Command | None:
        """React to slip of the held object. The loop calls this method repeatedly during a slip."""
        return None

    def late(self) -> Command | None:
        """Return the fallback command, because the deadline passed without an estimate."""
        return None
