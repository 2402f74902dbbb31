"""Policy that takes force and speed from the first estimate that is precise enough."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import GREEN, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp.policies.first_contact import LONGEST, FirstContact

if TYPE_CHECKING:
    from firstcontact.core import Estimate


class EarlyExit(FirstContact):
    """Policy that acts on the first estimate with a narrow interval, or on the last estimate."""

    name = "early_exit"
    title = "early exit"
    colour = GREEN

    def __init__(self, grip: Grip, window: float = LONGEST, tight: float = 10.0) -> None:
        super().__init__(grip, window)
        self.tight = tight
        self._acted = False

    def begin(self) -> Command:
        """Return the approach command and reset the state."""
        self._acted = False
        return super().begin()

    def estimated(self, estimate: Estimate) -> Command | None:
        """Return a command, once per closing, for a precise estimate or the last one."""
        precise = estimate.high - estimate.low <= self.tight
        last = estimate.final or estimate.elapsed >= self.window - 5e-4
        if self._acted or not (precise or last):
            return None
        self._acted = True
        return self.grip.command_for(min(estimate.low, estimate.value))
