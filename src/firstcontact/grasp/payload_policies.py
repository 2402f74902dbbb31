"""Policies that hold a payload of known weight as gently and as early as possible."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core import Command
from firstcontact.core.display import BLUE, GREEN, PURPLE
from firstcontact.grasp._grip import Grip
from firstcontact.grasp.policy import Policy

if TYPE_CHECKING:
    from firstcontact.core import Contact, Estimate

#: Length of the signal in the last estimate that a policy waits for, s.
WINDOW = 0.015
#: Time allowed after the window for the filter's look-ahead and the computing, s.
GRANTED = 0.010


class Touch(Policy):
    """Policy that closes gently after the first contact, and ignores the stiffness."""

    name = "touch"
    title = "gentle at touch"
    colour = PURPLE

    def touched(self, contact: Contact, first: bool) -> Command | None:
        return self.grip.gentle if first else None


class FirstContact(Policy):
    """Policy that closes gently after the contact, and then as fast as the estimate permits.

    It uses the lower end of the estimate's interval, so that a wide interval keeps it gentle.
    """

    name = "first_contact"
    title = "first contact"
    colour = BLUE

    def __init__(self, grip: Grip, window: float = WINDOW) -> None:
        super().__init__(grip)
        self.window = window
        self.deadline = window + GRANTED

    def touched(self, contact: Contact, first: bool) -> Command | None:
        return self.grip.gentle if first else None

    def estimated(self, estimate: Estimate) -> Command | None:
        return self._command_for_lower_end(estimate)

    def late(self) -> Command | None:
        return self.grip.gentle

    def _command_for_lower_end(self, estimate: Estimate) -> Command:
        """Return the command for the softest object in the estimate's interval."""
        return self.grip.command_for(min(estimate.low, estimate.value))


class EarlyExit(FirstContact):
    """Policy that acts once per contact: on the first narrow interval, or on the final estimate."""

    name = "early_exit"
    title = "early exit"
    colour = GREEN

    def __init__(self, grip: Grip, window: float = WINDOW, tight: float = 10.0) -> None:
        super().__init__(grip, window)
        self.tight = tight
        self._acted = False

    def begin(self) -> Command:
        self._acted = False
        return super().begin()

    def estimated(self, estimate: Estimate) -> Command | None:
        is_precise = estimate.high - estimate.low <= self.tight
        # Tolerance for rounding: a window's length is a whole number of samples.
        is_last = estimate.final or estimate.elapsed >= self.window - 5e-4
        if self._acted or not (is_precise or is_last):
            return None
        self._acted = True
        return self._command_for_lower_end(estimate)
