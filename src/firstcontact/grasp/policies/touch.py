"""Policy for comparison, which becomes gentle at the first contact with any object."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import PURPLE, Command
from firstcontact.grasp._policy import Part, Policy

if TYPE_CHECKING:
    from firstcontact.core import Contact


class Touch(Policy):
    """Policy that acts at first contact but uses no stiffness."""

    name = "touch"
    title = "gentle at touch"
    colour = PURPLE
    part = Part.CONTROL

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """At the first contact, return the command for the softest object."""
        return self.grip.gentle if first else None
