"""Slow down at the contact, set the force at the second: what all policies for a household do."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from firstcontact.core import Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Policy, Task, Tunable

if TYPE_CHECKING:
    from firstcontact.core import Contact

#: Closing speed from the first contact on, m/s.
SLOW = 0.03
#: A second contact that nobody heard is taken for granted so long after the first, s.
PATIENCE = 0.08
#: Speed of the approach, for whoever tunes it.
APPROACH = Tunable("Approach", "mm/s", 1e3, (0.07, 0.10, 0.13), (0.10,))


class FinalForce(Policy):
    """Closes slowly from the first contact on, and presses with one force from the second on.

    Only this force depends on what is known: slowing down never waits for anything.

    Parameters
    ----------
    grip
        What is declared of the hand.
    approach
        Closing speed until the first contact, m/s.
    scale
        What every force is multiplied by: the lower, the more cautious.
    """

    task = Task.HOUSEHOLD
    tunables: ClassVar = {"approach": APPROACH}

    def __init__(self, grip: Grip, approach: float = 0.10, scale: float = 1.0) -> None:
        super().__init__(grip)
        self.approach = approach
        self.scale = scale
        self._both = False

    @property
    def both(self) -> bool:
        """Whether it presses: both fingers touch, as far as it knows."""
        return self._both

    @abstractmethod
    def wanted(self) -> float:
        """Force to press with as far as is known now, N, before the scale."""

    @property
    def final(self) -> Command:
        """The command of the second contact, as far as is known now."""
        return self.grip.pressing(self.scale * self.wanted())

    @property
    def slow(self) -> Command:
        """The command of the first contact."""
        grip = self.grip
        return Command(min(SLOW, grip.speed), min(grip.searching, grip.force))

    @property
    def begun(self) -> Command:
        """The command of the approach."""
        grip = self.grip
        return Command(min(self.approach, grip.speed), min(grip.searching, grip.force))

    def begin(self) -> Command:
        """Approach, no stronger than that needs."""
        self._both = False
        return self.begun

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down, then press."""
        if first:
            return self.slow
        return self._press()

    def felt(self, volts: float, since: float | None) -> Command | None:
        """Press, where the second contact was not heard for too long."""
        if since is None or since < PATIENCE:
            return None
        return self._press()

    def _press(self) -> Command | None:
        if self._both:
            return None
        self._both = True
        return self.final
