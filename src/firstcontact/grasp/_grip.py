"""How hard and how fast to close on something, by mechanics: the rule of all who know stiffness."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

from firstcontact.core import Command, contact_modulus, gent_modulus, hertz_stiffness, holding_force

#: Poisson's ratio that the rule counts on: of what does not change its volume.
INCOMPRESSIBLE = 0.5


@dataclass(frozen=True, slots=True)
class Grip:
    """What is declared of a hand and its use, and what follows from it.

    The dent, the small margin and the searching force were chosen on closings that no report
    shows (docs/explanation/grasping.md); nothing else was chosen by a score.

    Parameters
    ----------
    speed
        Of the approach at each fingertip, m/s; nothing closes faster.
    force
        The most that the hand presses with, N.
    mass
        What moves with a fingertip, motor and gears included, kg.
    tip_radius
        Of a fingertip, m.
    pad_modulus
        Young's modulus of its pad, Pa.
    payload
        The heaviest thing that is to be held, kg.
    friction
        Coefficient that is counted on.
    margins
        Smallest and largest ratio of the force to what just holds the payload: the small
        one for what is soft or not known, the large one for what bears it.
    dent
        How deep a fingertip may press into pad and object together, m.
    searching
        Force that the approach is made with, N: enough to move, and to be felt.
    push
        Force that a stalled drive builds for each m/s that it is told to close, N s/m.
    """

    speed: float = 0.13
    force: float = 12.0
    mass: float = 0.47
    tip_radius: float = 0.010
    pad_modulus: float = 4.43e6
    payload: float = 0.2
    friction: float = 0.5
    margins: tuple[float, float] = (1.3, 2.0)
    dent: float = 0.5e-3
    searching: float = 1.0
    push: float = 250.0

    def stiffness(self, shore_a: float) -> float:
        """Hertz's K of a fingertip on a flat object of that Shore A, N/m^1.5."""
        young = gent_modulus(_within(shore_a))
        modulus = contact_modulus(self.pad_modulus, young, INCOMPRESSIBLE)
        return hertz_stiffness(modulus, self.tip_radius)

    @property
    def holding(self) -> float:
        """Force that just holds the payload between two fingers, N."""
        return holding_force(self.payload, self.friction)

    def force_for(self, shore_a: float) -> float:
        """Force that presses to the dent, within the margins and the hand's, N."""
        low, high = (m * self.holding for m in self.margins)
        bears: float = self.stiffness(shore_a) * self.dent**1.5
        return min(max(bears, low), high, self.force)

    def speed_for(self, shore_a: float) -> float:
        """Speed at which the moving mass alone presses to the dent, m/s (Hertz's impact)."""
        # m v^2 / 2 = (2/5) K dent^2.5
        bears: float = sqrt(0.8 * self.stiffness(shore_a) / self.mass) * self.dent**1.25
        return min(bears, self.speed)

    def command_for(self, shore_a: float) -> Command:
        """How to close on something of that Shore A."""
        return Command(self.speed_for(shore_a), self.force_for(shore_a))

    def pressing(self, force: float) -> Command:
        """As slow as still builds that force once both fingers touch."""
        within = min(force, self.force)
        return Command(min(1.1 * within / self.push, self.speed), within)

    @property
    def approach(self) -> Command:
        """At the approach's speed, and no stronger than that needs: nothing is held yet."""
        return Command(self.speed, min(self.searching, self.force))

    @property
    def gentle(self) -> Command:
        """What does for the softest thing on the scale: where nothing is known, and too late."""
        return self.command_for(0.0)


def _within(shore_a: float) -> float:
    """On the scale; at its upper end the modulus is infinite. No number is the softest."""
    return min(max(shore_a, 0.0), 99.0) if isfinite(shore_a) else 0.0
