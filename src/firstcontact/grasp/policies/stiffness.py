"""The force from the estimate and its interval: what is firm is pressed harder."""

from __future__ import annotations

from math import exp
from typing import ClassVar

from firstcontact.core import BLUE, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Stiffness, Tunable
from firstcontact.grasp.policies.final_force import FinalForce
from firstcontact.grasp.policies.first_contact import GRANTED, LONGEST


class ByStiffness(FinalForce):
    """A smooth step from one force to another, over the cautious end of the interval.

    The last estimate before the second contact counts. Where there is none the force lies
    between both.

    Parameters
    ----------
    grip
        What is declared of the hand.
    soft, firm
        Forces for the softest and the firmest, N.
    middle, width
        Where on the scale the step is, and how wide, Shore A.
    caution
        So many half widths of its interval are taken off an estimate.
    unknown
        Of the way from ``soft`` to ``firm`` where there is no estimate.
    approach, scale
        As of :class:`~firstcontact.grasp.policies.final_force.FinalForce`.
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
    deadline = LONGEST + GRANTED

    def __init__(
        self,
        grip: Grip,
        soft: float = 2.0,
        firm: float = 6.0,
        middle: float = 30.0,
        width: float = 5.0,
        caution: float = 0.25,
        unknown: float = 0.25,
        approach: float = 0.10,
        scale: float = 1.0,
    ) -> None:
        super().__init__(grip, approach, scale)
        self.soft, self.firm, self.middle, self.width = soft, firm, middle, width
        self.caution, self.unknown = caution, unknown
        self._told: Stiffness | None = None

    @property
    def told(self) -> Stiffness | None:
        """The estimate that counts, as far as there is one."""
        return self._told

    def begin(self) -> Command:
        """Approach, and know nothing."""
        self._told = None
        return super().begin()

    def estimated(self, stiffness: Stiffness) -> Command | None:
        """Remember it; press accordingly where both fingers touch, go on slowly until then."""
        self._told = stiffness
        return self.final if self._both else self.slow

    def late(self) -> Command | None:
        """Stay slow, or press as without any estimate: none came by the deadline."""
        if self._both:
            return self.final
        return Command(min(self.slow.speed, self.grip.gentle.speed), self.slow.force)

    def wanted(self) -> float:
        """The step, at the estimate less what it may be too high."""
        share = self.unknown
        if self._told is not None:
            half = (self._told.high - self._told.low) / 2
            away = (self._told.value - self.caution * half - self.middle) / self.width
            share = 1 / (1 + exp(-min(max(away, -50.0), 50.0)))
        return self.soft + share * (self.firm - self.soft)
