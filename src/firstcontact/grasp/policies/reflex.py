"""Press harder when the object slips."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from firstcontact.core import Command
from firstcontact.grasp._policy import Tunable
from firstcontact.grasp.policies.final_force import FinalForce

#: What a slip multiplies the force by.
BOOST = Tunable("Boost", "times", 1, (2.0, 3.0), (2.0,))


class Reflex(FinalForce):
    """Beside another of its kind: a slip raises the force.

    Each time it is told that the object slips, the force becomes ``boost`` times as high, up
    to the hand's, and is built as fast as the hand approaches.
    """

    boost: float = 2.0
    _times: int = 0
    extra: ClassVar[Mapping[str, Tunable]] = {"boost": BOOST}

    def begin(self) -> Command:
        """Nothing has slipped."""
        self._times = 0
        return super().begin()

    @property
    def final(self) -> Command:
        """What the policy presses with, raised as often as the object slipped."""
        command = super().final
        if not self._times:
            return command
        harder = self.grip.pressing(command.force * self.boost**self._times)
        return Command(max(harder.speed, self.begun.speed), harder.force)

    def slipped(self) -> Command | None:
        """Press harder."""
        if not self._both:
            return None
        if self.final.force < self.grip.force:
            self._times += 1
        return self.final
