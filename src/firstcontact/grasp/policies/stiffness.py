"""Policy with a force that grows with the estimated stiffness."""

from __future__ import annotations

from math import exp
from typing import TYPE_CHECKING, ClassVar

from firstcontact.core import BLUE, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Tunable
from firstcontact.grasp.policies.final_force import FinalForce
from firstcontact.grasp.policies.first_contact import GRANTED, LONGEST

if TYPE_CHECKING:
    from firstcontact.core import Estimate


class ByStiffness(FinalForce):
    """Policy whose force rises with the estimated stiffness, along a logistic curve.

    It uses the last estimate before the second contact, lowered by part of the interval. Without an
    estimate the force lies between the lowest and the highest force.

    Parameters
    ----------
    grip
        Declared properties of the hand.
    soft, firm
        Forces for the softest and the firmest objects, N.
    middle, width
        Centre and width of the curve, Shore A.
    caution
        Number of half widths of the interval to subtract from an estimate.
    unknown
        Force without an estimate, as a position between ``soft`` (0) and ``firm`` (1).
    approach, scale
        As in :class:`~firstcontact.grasp.policies.final_force.FinalForce`.
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
        self._estimate: Estimate | None = None

    @property
    def estimate(self) -> Estimate | None:
        """Estimate that determines the force; None without one."""
        return self._estimate

    def begin(self) -> Command:
        """Return the approach command and discard the last estimate."""
        self._estimate = None
        return super().begin()

    def estimated(self, estimate: Estimate) -> Command | None:
        """Store the estimate. Press with its force if both fingers touch, otherwise stay slow."""
        self._estimate = estimate
        return self.final if self._both else self.slow

    def late(self) -> Command | None:
        """Stay slow, or press if both fingers touch already.

        Without an estimate the force is the one that ``unknown`` sets.
        """
        if self._both:
            return self.final
        return Command(min(self.slow.speed, self.grip.gentle.speed), self.slow.force)

    def target_force(self) -> float:
        """Return the force for an estimate that is lowered by ``caution`` half widths, N."""
        share = self.unknown
        if self._estimate is not None:
            half = (self._estimate.high - self._estimate.low) / 2
            offset = (self._estimate.value - self.caution * half - self.middle) / self.width
            share = 1 / (1 + exp(-min(max(offset, -50.0), 50.0)))
        return self.soft + share * (self.firm - self.soft)
