"""Force and speed from the estimate at first contact."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import BLUE, Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Policy, Stiffness

if TYPE_CHECKING:
    from firstcontact.core import Contact

#: How long the longest window is, s.
LONGEST = 0.015
#: What is granted for its end, the filter's look-ahead and the computing, s.
GRANTED = 0.010


class FirstContact(Policy):
    """Gentle from the contact on, as nothing is known then; what is firm is let go faster.

    Takes the soft end of the interval for true: a wide one is gentle by itself.

    Parameters
    ----------
    grip
        What is declared of the hand.
    window
        The window whose estimate it waits for, s; shorter ones are passed over where another is
        to come.
    """

    name = "first_contact"
    title = "first contact"
    colour = BLUE

    def __init__(self, grip: Grip, window: float = LONGEST) -> None:
        super().__init__(grip)
        self.window = window
        self.deadline = window + GRANTED

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down for the softest thing at the first contact."""
        return self.grip.gentle if first else None

    def estimated(self, stiffness: Stiffness) -> Command | None:
        """Close as the soft end of the interval bears."""
        # Half a sample at any rate: a window's length is a whole number of them.
        if stiffness.duration < self.window - 5e-4 and not stiffness.standing:
            return None
        return self.grip.command_for(min(stiffness.low, stiffness.value))

    def late(self) -> Command | None:
        """Slow and gentle."""
        return self.grip.gentle
