"""A policy that does nothing: the rest are told by what they do besides."""

from __future__ import annotations

from firstcontact.core import Command, Contact
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policy import Stiffness


class Quiet:
    """Closes as it began, whatever happens.

    Parameters
    ----------
    grip
        What is declared of the hand.
    """

    name = "quiet"
    deadline: float | None = None

    def __init__(self, grip: Grip) -> None:
        self.grip = grip

    def begin(self) -> Command:
        """At the approach's speed, no stronger than the softest thing is held."""
        return self.grip.approach

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Nothing."""
        return None

    def estimated(self, stiffness: Stiffness) -> Command | None:
        """Nothing."""
        return None

    def felt(self, volts: float, since: float | None) -> Command | None:
        """Nothing."""
        return None

    def late(self) -> Command | None:
        """Nothing."""
        return None
