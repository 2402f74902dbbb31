"""No modulation: fixed speed, fixed force."""

from __future__ import annotations

from firstcontact.core import Command
from firstcontact.grasp.policies.quiet import Quiet


class NoModulation(Quiet):
    """The approach's speed and the hand's force, until it stalls."""

    name = "none"

    def begin(self) -> Command:
        """Close, as strong as the hand is."""
        return Command(self.grip.speed, self.grip.force)
