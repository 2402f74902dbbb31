"""Policy whose force rises with the stiffness, and at each slip."""

from __future__ import annotations

from typing import ClassVar

from firstcontact.core import GREEN
from firstcontact.grasp._grip import Grip
from firstcontact.grasp.policies.reflex import Reflex
from firstcontact.grasp.policies.stiffness import ByStiffness


class StiffnessReflex(Reflex, ByStiffness):
    """Policy whose force rises with the estimated stiffness, and at each slip."""

    name = "stiffness_reflex"
    title = "stiffness and reflex"
    colour = GREEN
    tunables: ClassVar = {**ByStiffness.tunables, **Reflex.extra}

    def __init__(self, grip: Grip, boost: float = 2.0, **settings: float) -> None:
        super().__init__(grip, **settings)
        self.boost = boost
