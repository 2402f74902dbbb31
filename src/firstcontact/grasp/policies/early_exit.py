"""Force and speed from the first estimate that is sure enough."""

from __future__ import annotations

from firstcontact.core import GREEN, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Stiffness
from firstcontact.grasp.policies.first_contact import LONGEST, FirstContact


class EarlyExit(FirstContact):
    """Acts on the first estimate whose interval is tight, or on that of the longest window.

    Parameters
    ----------
    grip
        What is declared of the hand.
    window
        The longest window, s.
    tight
        An interval no wider than this is acted upon, Shore A. A quarter of what everyday
        objects span (28 to 67 in the paper).
    """

    name = "early_exit"
    title = "early exit"
    colour = GREEN

    def __init__(self, grip: Grip, window: float = LONGEST, tight: float = 10.0) -> None:
        super().__init__(grip, window)
        self.tight = tight
        self._acted = False

    def begin(self) -> Command:
        """As all that wait for an estimate."""
        self._acted = False
        return super().begin()

    def estimated(self, stiffness: Stiffness) -> Command | None:
        """Close as the soft end of the interval bears, once."""
        sure = stiffness.high - stiffness.low <= self.tight
        last = stiffness.standing or stiffness.duration >= self.window - 5e-4
        if self._acted or not (sure or last):
            return None
        self._acted = True
        return self.grip.command_for(min(stiffness.low, stiffness.value))
