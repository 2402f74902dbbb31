"""Policy that takes force and speed from the estimate after the first contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import BLUE, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Policy

if TYPE_CHECKING:
    from firstcontact.core import Contact, Estimate

#: Length of the longest window, s.
LONGEST = 0.015
#: Time allowed after the window for the filter's look-ahead and the computing, s.
GRANTED = 0.010


class FirstContact(Policy):
    """Policy that is gentle after the contact and faster once the object proves firm."""

    name = "first_contact"
    title = "first contact"
    colour = BLUE
    early = True

    def __init__(self, grip: Grip, window: float = LONGEST) -> None:
        super().__init__(grip)
        self.window = window
        self.deadline = window + GRANTED

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """At the first contact, return the command for the softest object."""
        return self.grip.gentle if first else None

    def estimated(self, estimate: Estimate) -> Command | None:
        """Return the command for the lower bound of the interval."""
        # Tolerance for rounding: a window's length is a whole number of samples.
        if estimate.elapsed < self.window - 5e-4 and not estimate.final:
            return None
        return self.grip.command_for(min(estimate.low, estimate.value))

    def late(self) -> Command | None:
        """Return the command for the softest object, because the estimate missed its deadline."""
        return self.grip.gentle
