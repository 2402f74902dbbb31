"""The control of the estimate: gentle at every contact, whatever was touched."""

from __future__ import annotations

from firstcontact.core import Command, Contact
from firstcontact.grasp.policies.quiet import Quiet


class Touch(Quiet):
    """What first contact saves without knowing any stiffness."""

    name = "touch"

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down for the softest thing at the first contact."""
        return self.grip.gentle if first else None
