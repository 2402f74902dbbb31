"""Grip force and closing speed for a given stiffness, from contact mechanics."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt

from firstcontact.core import Command
from firstcontact.core.physics import contact_modulus, gent_modulus, hertz_stiffness, holding_force

#: Poisson's ratio of an incompressible material. The rule assumes it for every object.
INCOMPRESSIBLE = 0.5


@dataclass(frozen=True, slots=True)
class Grip:
    """Properties of a hand and its payload, from which grip commands are computed.

    The values of ``dent``, ``searching`` and the smaller of ``margins`` were tuned on closings that
    no published score uses (docs/explanation/grasping.md). No other value was tuned.

    Parameters
    ----------
    speed
        Approach speed at each fingertip, m/s. It is also the upper limit of every command.
    force
        Highest force of the hand, N.
    mass
        Mass that moves with a fingertip, motor and gears included, kg.
    tip_radius
        Radius of a fingertip, m.
    pad_modulus
        Young's modulus of the fingertip's pad, Pa.
    payload
        Mass of the heaviest object to hold, kg.
    friction
        Assumed coefficient of friction.
    margins
        Smallest and largest ratio of the grip force to the force that just holds the payload. The
        smaller ratio applies to soft and unknown objects, the larger one to firm objects.
    dent
        Indentation of pad and object together that the commands allow, m.
    searching
        Force limit of the approach, N: enough to move the finger and to feel a contact.
    push
        Force that a stalled drive builds for each m/s of commanded closing speed, N s/m.
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
        """Return the contact stiffness of a fingertip on a flat object of this Shore A, N/m^1.5.

        It is force / indentation^1.5 (Hertz).
        """
        young = gent_modulus(_clip_shore_a(shore_a))
        modulus = contact_modulus(self.pad_modulus, young, INCOMPRESSIBLE)
        return hertz_stiffness(modulus, self.tip_radius)

    @property
    def holding(self) -> float:
        """Smallest grip force that holds the payload between two fingers, N."""
        return holding_force(self.payload, self.friction)

    def force_for(self, shore_a: float) -> float:
        """Return the grip force, N, that dents pad and object together by ``dent``.

        The force is clipped to ``margins`` times :attr:`holding`, and is at most ``force``.
        """
        low, high = (m * self.holding for m in self.margins)
        force: float = self.stiffness(shore_a) * self.dent**1.5
        return min(max(force, low), high, self.force)

    def speed_for(self, shore_a: float) -> float:
        """Return the closing speed, m/s, at which the impact dents pad and object by ``dent``.

        The speed is at most ``speed``.
        """
        # Hertz's theory of impact: m v^2 / 2 = (2/5) K dent^2.5
        speed: float = sqrt(0.8 * self.stiffness(shore_a) / self.mass) * self.dent**1.25
        return min(speed, self.speed)

    def command_for(self, shore_a: float) -> Command:
        """Return closing speed and grip force for an object with this hardness, Shore A."""
        return Command(self.speed_for(shore_a), self.force_for(shore_a))

    def pressing(self, force: float) -> Command:
        """Return the slowest command with which a stalled drive builds the grip force ``force``, N.

        Send it once both fingers touch.
        """
        limited = min(force, self.force)
        return Command(min(1.1 * limited / self.push, self.speed), limited)

    @property
    def approach(self) -> Command:
        """Command before the first contact: closing speed ``speed``, force limit ``searching``."""
        return Command(self.speed, min(self.searching, self.force))

    @property
    def gentle(self) -> Command:
        """Command for the softest object, 0 Shore A, to use while the stiffness is unknown."""
        return self.command_for(0.0)


def _clip_shore_a(shore_a: float) -> float:
    """Return a Shore A clipped to the range from 0 to 99. NaN and infinity become 0."""
    return min(max(shore_a, 0.0), 99.0) if isfinite(shore_a) else 0.0
