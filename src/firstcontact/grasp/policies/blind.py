"""Baseline policy, which presses every object with one force."""

from __future__ import annotations

from typing import ClassVar

from firstcontact.core import ORANGE
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Part, Tunable
from firstcontact.grasp.policies.final_force import FinalForce

#: Tunable force.
FORCE = Tunable("Force", "N", 1, (1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0), (2.0, 3.0, 4.0))


class Blind(FinalForce):
    """Policy that acts on the contacts and presses every object with the same force."""

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

    def target_force(self) -> float:
        """Return the same force for every object."""
        return self.force
