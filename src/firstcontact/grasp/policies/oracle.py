"""The upper limit: somebody who knows at the contact what is touched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import Command
from firstcontact.core.palette import INK
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policy import Part, Policy

if TYPE_CHECKING:
    from firstcontact.core import Contact


class Oracle(Policy):
    """Closes as the true Shore A bears from the moment at which the contact is known.

    Parameters
    ----------
    grip
        What is declared of the hand.
    shore_a
        The truth.
    """

    name = "oracle"
    title = "oracle"
    colour = INK
    part = Part.LIMIT
    needs_truth = True

    def __init__(self, grip: Grip, shore_a: float) -> None:
        super().__init__(grip)
        self.shore_a = shore_a

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Close as it bears."""
        return self.grip.command_for(self.shore_a) if first else None
