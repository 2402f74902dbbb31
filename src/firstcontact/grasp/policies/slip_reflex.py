"""Policy that presses every object with one force, and harder at each slip."""

from __future__ import annotations

from typing import ClassVar

from firstcontact.core import PURPLE
from firstcontact.grasp._grip import Grip
from firstcontact.grasp.policies.blind import Blind
from firstcontact.grasp.policies.reflex import Reflex


class SlipReflex(Reflex, Blind):
    """Policy that presses every object with the same force at first, and harder at each slip."""

    name = "slip_reflex"
    title = "slip reflex"
    colour = PURPLE
    tunables: ClassVar = {**Blind.tunables, **Reflex.extra}

    def __init__(
        self,
        grip: Grip,
        force: float = 2.5,
        boost: float = 2.0,
        approach: float = 0.10,
        scale: float = 1.0,
    ) -> None:
        super().__init__(grip, force, approach, scale)
        self.boost = boost
