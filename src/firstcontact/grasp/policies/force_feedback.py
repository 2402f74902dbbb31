"""The classic: close until the force sensors say that something is there."""

from __future__ import annotations

from dataclasses import dataclass

from firstcontact.core import Command
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policies.quiet import Quiet


@dataclass(frozen=True, slots=True)
class Feedback:
    """Settings of force feedback.

    Parameters
    ----------
    threshold
        How far a taxel rises for something to be there, V.
    approach
        Force limit until then, N.
    speed
        Closing speed from then on, m/s.
    force
        Force limit from then on, N.
    """

    threshold: float = 0.05
    approach: float = 2.5
    speed: float = 0.04
    force: float = 2.2


class ForceFeedback(Quiet):
    """Slows down and limits the force once a taxel rises, whatever is touched."""

    name = "force_feedback"

    def __init__(self, grip: Grip, settings: Feedback | None = None) -> None:
        super().__init__(grip)
        self.settings = settings or Feedback()
        self._acted = False

    def begin(self) -> Command:
        """Close at the approach's speed with the limit of the approach."""
        self._acted = False
        return Command(self.grip.speed, min(self.settings.approach, self.grip.force))

    def felt(self, volts: float, since: float | None) -> Command | None:
        """Act once, when a taxel is above the threshold."""
        if self._acted or not volts > self.settings.threshold:
            return None
        self._acted = True
        chosen = self.settings
        return Command(min(chosen.speed, self.grip.speed), min(chosen.force, self.grip.force))
