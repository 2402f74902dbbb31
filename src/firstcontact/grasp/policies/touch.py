"""The control of the estimate: gentle at every contact, whatever was touched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import PURPLE, Command
from firstcontact.grasp._policy import Part, Policy

if TYPE_CHECKING:
    from firstcontact.core import Contact


class Touch(Policy):
    """What first contact saves without knowing any stiffness."""

    name = "touch"
    title = "gentle at touch"
    colour = PURPLE
    part = Part.CONTROL

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down for the softest thing at the first contact."""
        return self.grip.gentle if first else None
