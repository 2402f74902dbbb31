"""Base class of policies for household objects, which close slowly after the first contact."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, ClassVar

from firstcontact.core import Command
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Policy, Task, Tunable

if TYPE_CHECKING:
    from firstcontact.core import Contact

#: Closing speed after the first contact, m/s.
SLOW = 0.03
#: Time after the first contact from which the policy assumes an undetected second one, s.
PATIENCE = 0.08
#: Tunable speed of the approach.
APPROACH = Tunable("Approach", "mm/s", 1e3, (0.07, 0.10, 0.13), (0.10,))


class FinalForce(Policy):
    """Policy that closes slowly after the first contact and sets its force at the second.

    Only this force depends on the stiffness. Slowing down never waits for an estimate.

    Parameters
    ----------
    grip
        Declared properties of the hand.
    approach
        Closing speed until the first contact, m/s.
    scale
        Factor on every force. A lower factor is more cautious.
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
        """True if the policy presses, because it knows or assumes that both fingers touch."""
        return self._both

    @abstractmethod
    def target_force(self) -> float:
        """Return the grip force, N, for what the policy knows by now, without ``scale``."""

    @property
    def final(self) -> Command:
        """Command after the second contact, for what the policy knows by now."""
        return self.grip.pressing(self.scale * self.target_force())

    @property
    def slow(self) -> Command:
        """Command after the first contact."""
        grip = self.grip
        return Command(min(SLOW, grip.speed), min(grip.searching, grip.force))

    @property
    def begun(self) -> Command:
        """Command for the approach."""
        grip = self.grip
        return Command(min(self.approach, grip.speed), min(grip.searching, grip.force))

    def begin(self) -> Command:
        """Return the approach command."""
        self._both = False
        return self.begun

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """Slow down at the first contact, press at the second."""
        if first:
            return self.slow
        return self._press()

    def felt(self, volts: float, since: float | None) -> Command | None:
        """Press if no second contact was detected within :data:`PATIENCE` s after the first."""
        if since is None or since < PATIENCE:
            return None
        return self._press()

    def _press(self) -> Command | None:
        if self._both:
            return None
        self._both = True
        return self.final
