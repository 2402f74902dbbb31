"""The baseline: one force for everything."""

from __future__ import annotations

from typing import ClassVar

from firstcontact.core import ORANGE
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Part, Tunable
from firstcontact.grasp.policies.final_force import FinalForce

#: The force, for whoever tunes one.
FORCE = Tunable("Force", "N", 1, (1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0), (2.0, 3.0, 4.0))


class Blind(FinalForce):
    """Knows when the fingers touch, and nothing of what they touch.

    Parameters
    ----------
    grip
        What is declared of the hand.
    force
        To press with, N.
    approach, scale
        As of :class:`~firstcontact.grasp.policies.final_force.FinalForce`.
    """

    name = "blind"
    title = "blind"
    colour = ORANGE
    part = Part.BASELINE
    tunables: ClassVar = {**FinalForce.tunables, "force": FORCE}

    def __init__(
        self, grip: Grip, force: float = 3.5, approach: float = 0.10, scale: float = 1.0
    ) -> None:
        super().__init__(grip, approach, scale)
        self.force = force

    def wanted(self) -> float:
        """The same for everything."""
        return self.force
