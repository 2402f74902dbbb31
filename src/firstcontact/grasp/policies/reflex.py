"""Slip reflex: a mixin that raises the grip force on slip."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from firstcontact.core import Command
from firstcontact.grasp._policy import Tunable
from firstcontact.grasp.policies.final_force import FinalForce

#: Tunable factor on the force at each slip.
BOOST = Tunable("Boost", "times", 1, (2.0, 3.0), (2.0,))


class Reflex(FinalForce):
    """Mixin that raises the grip force on slip. Combine it with a policy for household objects."""

    boost: float = 2.0
    _slips: int = 0
    extra: ClassVar[Mapping[str, Tunable]] = {"boost": BOOST}

    def begin(self) -> Command:
        """Return the approach command and forget earlier slips."""
        self._slips = 0
        return super().begin()

    @property
    def final(self) -> Command:
        """Command after the second contact. Each slip so far multiplied its force by ``boost``."""
        command = super().final
        if not self._slips:
            return command
        harder = self.grip.pressing(command.force * self.boost**self._slips)
        return Command(max(harder.speed, self.begun.speed), harder.force)

    def slipped(self) -> Command | None:
        """Raise the force if the hand already presses with both fingers."""
        if not self._both:
            return None
        if self.final.force < self.grip.force:
            self._slips += 1
        return self.final
