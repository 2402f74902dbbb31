"""No modulation: fixed speed, fixed force."""

from __future__ import annotations

from firstcontact.core import GREY, Command
from firstcontact.grasp._policy import Part, Policy


class NoModulation(Policy):
    """The approach's speed and the hand's force, until it stalls."""

    name = "none"
    title = "no modulation"
    colour = GREY
    part = Part.UNMODULATED

    def begin(self) -> Command:
        """Close, as strong as the hand is."""
        return Command(self.grip.speed, self.grip.force)
