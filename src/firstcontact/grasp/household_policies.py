"""Policies for household objects: slow after the first contact, fixed force at the second."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field
from math import exp
from typing import TYPE_CHECKING, ClassVar

from firstcontact.core import Command
from firstcontact.core.display import BLUE, GREEN, INK, ORANGE, PURPLE
from firstcontact.core.physics import holding_force
from firstcontact.grasp._grip import Grip
from firstcontact.grasp.payload_policies import GRANTED, WINDOW
from firstcontact.grasp.policy import Policy, PolicyRole, Task, Truth, Tunable

if TYPE_CHECKING:
    from firstcontact.core import Contact, Estimate

#: Closing speed after the first contact, m/s.
SLOW = 0.03
#: Time after the first contact from which the policy assumes an undetected second one, s.
PATIENCE = 0.08
#: Tunable speed of the approach.
APPROACH = Tunable("Approach", "mm/s", 1e3, (0.07, 0.10, 0.13), (0.10,))
#: Tunable force.
FORCE = Tunable("Force", "N", 1, (1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0), (2.0, 3.0, 4.0))
#: Tunable factor on the force at each slip.
BOOST = Tunable("Boost", "times", 1, (2.0, 3.0), (2.0,))


@dataclass(eq=False)
class FinalForce(Policy):
    """Policy that closes slowly after the first contact, and sets its grip force at the second.

    Subclasses override :meth:`target_force`.
    """

    task = Task.HOUSEHOLD
    tunables: ClassVar = {"approach": APPROACH}

    grip: Grip
    #: Closing speed until the first contact, m/s.
    approach: float = field(default=0.10, kw_only=True)
    #: Factor on every force.
    scale: float = field(default=1.0, kw_only=True)
    #: True if the policy presses, because it knows or assumes that both fingers touch.
    both: bool = field(default=False, init=False)

    @abstractmethod
    def target_force(self) -> float:
        """Return the grip force for the held object, N, before it is multiplied by ``scale``."""

    @property
    def final(self) -> Command:
        return self.grip.pressing(self.scale * self.target_force())

    @property
    def slow(self) -> Command:
        grip = self.grip
        return Command(min(SLOW, grip.speed), min(grip.searching, grip.force))

    @property
    def first_command(self) -> Command:
        grip = self.grip
        return Command(min(self.approach, grip.speed), min(grip.searching, grip.force))

    def begin(self) -> Command:
        self.both = False
        return self.first_command

    def touched(self, contact: Contact, first: bool) -> Command | None:
        return self.slow if first else self._press()

    def felt(self, volts: float, since: float | None) -> Command | None:
        """Return the final command if no second contact came :data:`PATIENCE` s after the first."""
        return None if since is None or since < PATIENCE else self._press()

    def _press(self) -> Command | None:
        if self.both:
            return None
        self.both = True
        return self.final


@dataclass(eq=False)
class Blind(FinalForce):
    """Policy that ignores the stiffness and presses every object with the same force."""

    name = "blind"
    title = "blind"
    colour = ORANGE
    part = PolicyRole.BASELINE
    tunables: ClassVar = {**FinalForce.tunables, "force": FORCE}

    force: float = 3.5

    def target_force(self) -> float:
        return self.force


@dataclass(eq=False)
class ByStiffness(FinalForce):
    """Policy whose grip force rises with the estimated stiffness, along a logistic curve.

    It uses the last estimate before the second contact, lowered by ``caution`` half widths of the
    interval. The curve rises from the force ``soft`` to ``firm``, N. Its centre ``middle`` and its
    width ``width`` are in Shore A. Without an estimate, ``unknown`` is the position between
    ``soft`` (0) and ``firm`` (1).
    """

    name = "stiffness"
    title = "stiffness"
    colour = BLUE
    tunables: ClassVar = {
        **FinalForce.tunables,
        "soft": Tunable("Soft", "N", 1, (1.5, 2.0, 2.5, 3.0), (1.5, 2.5)),
        "firm": Tunable("Firm", "N", 1, (4.0, 5.0, 6.0, 8.0, 10.0), (4.0, 8.0)),
        "middle": Tunable("Middle", "Shore A", 1, (15, 20, 25, 30, 35, 40, 50), (20, 30, 40)),
        "width": Tunable("Width", "Shore A", 1, (2, 5, 10), (2, 5)),
        "caution": Tunable("Caution", "half widths", 1, (0.0, 0.25, 0.5, 1.0), (0.0, 0.5)),
        "unknown": Tunable("Unknown", "of the way", 1, (0.0, 0.25, 0.5), (0.25,)),
    }
    deadline = WINDOW + GRANTED

    soft: float = 2.0
    firm: float = 6.0
    middle: float = 30.0
    width: float = 5.0
    caution: float = 0.25
    unknown: float = 0.25
    #: Estimate that determines the force; None without one.
    estimate: Estimate | None = field(default=None, init=False)

    def begin(self) -> Command:
        self.estimate = None
        return super().begin()

    def estimated(self, estimate: Estimate) -> Command | None:
        self.estimate = estimate
        return self.final if self.both else self.slow

    def late(self) -> Command | None:
        self.estimate = None
        if self.both:
            return self.final
        return Command(min(self.slow.speed, self.grip.gentle.speed), self.slow.force)

    def target_force(self) -> float:
        share = self.unknown
        if (estimate := self.estimate) is not None:
            half = (estimate.high - estimate.low) / 2
            offset = (estimate.value - self.caution * half - self.middle) / self.width
            share = 1 / (1 + exp(-min(max(offset, -50.0), 50.0)))
        return self.soft + share * (self.firm - self.soft)


@dataclass(eq=False)
class ByWeight(FinalForce):
    """Policy whose grip force follows from the known weight and an assumed friction.

    Bounds limit the force.
    """

    name = "weight"
    title = "weight known"
    colour = INK
    part = PolicyRole.LIMIT
    needs_truth = True
    tunables: ClassVar = {
        **FinalForce.tunables,
        "margin": Tunable("Margin", "times", 1, (1.2, 1.5, 2.0, 2.5, 3.0), (1.5, 2.5)),
        "least": Tunable("At least", "N", 1, (1.0, 1.5, 2.0, 2.5, 3.0), (1.5, 2.5)),
        "most": Tunable("At most", "N", 1, (4.0, 6.0, 8.0, 12.0), (8.0,)),
    }

    truth: Truth
    margin: float = 1.5
    least: float = 1.5
    most: float = 8.0

    def target_force(self) -> float:
        holding = holding_force(self.truth.mass, self.grip.friction)
        return min(max(self.margin * holding, self.least), self.most)


@dataclass(eq=False)
class Reflex(FinalForce):
    """Mixin that raises the grip force at each slip. Combine it with a policy."""

    tunables: ClassVar = {"boost": BOOST}
    boost: float = field(default=2.0, kw_only=True)
    _slips: int = field(default=0, init=False)

    def begin(self) -> Command:
        self._slips = 0
        return super().begin()

    @property
    def final(self) -> Command:
        """Command after the second contact. Each slip multiplies the grip force by ``boost``."""
        command = super().final
        if not self._slips:
            return command
        harder = self.grip.pressing(command.force * self.boost**self._slips)
        return Command(max(harder.speed, self.first_command.speed), harder.force)

    def slipped(self) -> Command | None:
        if not self.both:
            return None
        if self.final.force < self.grip.force:
            self._slips += 1
        return self.final


@dataclass(eq=False)
class SlipReflex(Reflex, Blind):
    """Policy that starts with the same grip force for every object, and raises it at each slip."""

    name = "slip_reflex"
    title = "slip reflex"
    colour = PURPLE
    tunables: ClassVar = {**Blind.tunables, **Reflex.tunables}
    force: float = 2.5


@dataclass(eq=False)
class StiffnessReflex(Reflex, ByStiffness):
    """Policy whose grip force rises with the estimated stiffness, and at each slip."""

    name = "stiffness_reflex"
    title = "stiffness and reflex"
    colour = GREEN
    tunables: ClassVar = {**ByStiffness.tunables, **Reflex.tunables}
