"""The upper limit: somebody who knows at the contact what is touched."""

from __future__ import annotations

from firstcontact.core import Command, Contact
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policies.quiet import Quiet


class Oracle(Quiet):
    """Closes as the true Shore A bears from the moment at which the contact is known.

    Parameters
    ----------
    grip
        What is declared of the hand.
    shore_a
        The truth.
    """

    name = "oracle"

    def __init__(self, grip: Grip, shore_a: float) -> None:
        super().__init__(grip)
        self.shore_a = shore_a

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Close as it bears."""
        return self.grip.command_for(self.shore_a) if first else None
