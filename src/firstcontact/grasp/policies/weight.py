"""Reference policy, which computes its force from the object's known weight."""

from __future__ import annotations

from typing import ClassVar

from firstcontact.core import INK, holding_force
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Part, Truth, Tunable
from firstcontact.grasp.policies.final_force import FinalForce


class ByWeight(FinalForce):
    """Policy whose force follows from the known weight and an assumed friction, within bounds."""

    name = "weight"
    title = "weight known"
    colour = INK
    part = Part.LIMIT
    needs_truth = True
    tunables: ClassVar = {
        **FinalForce.tunables,
        "margin": Tunable("Margin", "times", 1, (1.2, 1.5, 2.0, 2.5, 3.0), (1.5, 2.5)),
        "least": Tunable("At least", "N", 1, (1.0, 1.5, 2.0, 2.5, 3.0), (1.5, 2.5)),
        "most": Tunable("At most", "N", 1, (4.0, 6.0, 8.0, 12.0), (8.0,)),
    }

    def __init__(
        self,
        grip: Grip,
        truth: Truth,
        margin: float = 1.5,
        least: float = 1.5,
        most: float = 8.0,
        approach: float = 0.10,
        scale: float = 1.0,
    ) -> None:
        super().__init__(grip, approach, scale)
        self.mass, self.margin, self.least, self.most = truth.mass, margin, least, most

    def target_force(self) -> float:
        """Return the force that holds the object's weight with the margin, within the bounds, N."""
        holding = holding_force(self.mass, self.grip.friction)
        return min(max(self.margin * holding, self.least), self.most)
