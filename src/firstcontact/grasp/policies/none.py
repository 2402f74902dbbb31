"""Policy without modulation, with a fixed speed and a fixed force."""

from __future__ import annotations

from firstcontact.core import GREY, Command
from firstcontact.grasp._policy import Part, Policy


class NoModulation(Policy):
    """Policy that closes at approach speed with the hand's full force until the hand stalls."""

    name = "none"
    title = "no modulation"
    colour = GREY
    part = Part.UNMODULATED

    def begin(self) -> Command:
        """Return the approach speed with the hand's full force."""
        return Command(self.grip.speed, self.grip.force)
