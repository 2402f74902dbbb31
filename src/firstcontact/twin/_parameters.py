"""Parameters of the mechanics, with their nominal values.

``docs/reference/twin-parameters.md`` states the source of each number.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from firstcontact.core import gent_modulus


class FingerParameters(NamedTuple):
    """Parameters of one finger, from its drive to its skin. SI units."""

    speed: float = 0.13
    """Closing speed of the finger, m/s."""
    drive_mass: float = 0.45
    """Inertia of motor and gears, as an equivalent mass at the fingertip, kg."""
    speed_gain: float = 250.0
    """Gain of the drive's speed loop, N s/m."""
    drive_force: float = 12.0
    """Stall force at the fingertip, N."""
    link_stiffness: float = 2.5e3
    """Stiffness of gear train and linkage between drive and phalanx, N/m."""
    link_damping: float = 3.0
    """Damping of gear train and linkage, N s/m."""
    phalanx_mass: float = 0.018
    """Mass of distal phalanx and mount, kg."""
    mount_stiffness: float = 4.2e5
    """Stiffness of the screwed PETG mount under the board, N/m."""
    mount_damping: float = 2.6
    """Damping of the mount, N s/m."""
    board_mass: float = 0.0021
    """Mass of the board with piezo disc and wires, kg."""
    pad_stiffness: float = 4.5e4
    """Stiffness of the dimpled pad at small compression, N/m."""
    pad_stiffening: float = 6.0e11
    """Cubic term of the dimpled pad's stiffness, N/m^3."""
    pad_arm_stiffness: float = 2.2e4
    """Stiffness of the pad's Maxwell arm, N/m."""
    pad_relaxation: float = 1.2e-3
    """Relaxation time of the pad's Maxwell arm, s."""
    pad_damping: float = 1.5
    """Damping of the pad, N s/m."""
    skin_mass: float = 0.00055
    """Mass of the pad's front, which moves with the skin, kg."""
    pad_modulus: float = 4.43e6
    """Young's modulus of the pad's silicone, Pa: that of 65 Shore A by Gent's formula."""
    tip_radius: float = 0.010
    """Radius of curvature of the tip at the contact, m."""
    piezo_volts_per_newton: float = 0.0325
    """Open-circuit voltage of the disc per newton through the mount, V/N."""
    piezo_time_constant: float = 2.8e-3
    """Disc capacitance times the buffer's input resistance, s."""
    gain: float = 22.0
    """Gain of the non-inverting buffer."""
    buffer_cutoff: float = 1.8e3
    """Cutoff frequency of the buffer, a first-order low-pass filter, Hz."""


class ObjectParameters(NamedTuple):
    """Parameters of the object: two faces, the bulk between them, and its support. SI units."""

    modulus: float = 1.0e6
    """Young's modulus in a slow indentation, Pa."""
    radius: float = 1.0e3
    """Radius of curvature at the contact, m. The default is that of flat objects."""
    face_mass: float = 0.095
    """Mass that moves with each face, kg."""
    bulk_stiffness: float = 1.4e5
    """Stiffness between the faces, N/m."""
    bulk_damping: float = 30.0
    """Damping between the faces, N s/m."""
    clamp_stiffness: float = 150.0
    """Stiffness of the support, N/m."""
    clamp_damping: float = 1.5
    """Damping of the support, N s/m."""
    arm_share: float = 0.25
    """Stiffness of the contact's Maxwell arm, as a share of the slow contact stiffness."""
    arm_relaxation: float = 4.0e-3
    """Relaxation time of the contact's Maxwell arm, s."""
    contact_loss: float = 0.10
    """Coefficient c of the Hunt-Crossley loss, s/m. At a speed of impact v the
    restitution is about 1 - c v."""

    @classmethod
    def solid(cls, shore_a: float, mass: float, bulk: float, loss: float) -> ObjectParameters:
        """Return a solid from Shore A, mass (kg), bulk stiffness (N/m) and its loss factor.

        The loss also affects relaxation and contact.
        """
        return cls(
            modulus=gent_modulus(shore_a),
            face_mass=mass / 2,
            bulk_stiffness=bulk,
            bulk_damping=loss * math.sqrt(bulk * mass / 4),
            arm_share=2 * loss,
            contact_loss=loss,
        )

    def stiffened(self, factor: float) -> ObjectParameters:
        """Return the object with its modulus multiplied by ``factor``."""
        return self._replace(
            modulus=self.modulus * factor, bulk_stiffness=self.bulk_stiffness * factor
        )


class Timing(NamedTuple):
    """Contact times, s from the first sample."""

    first: float
    second: float
    first_is_index: bool


class VelostatParameters(NamedTuple):
    """Parameters of one fingertip's force array. SI units."""

    threshold: float = 0.30
    """Force on a taxel up to which the conductance does not rise, N."""
    rise: float = 0.030
    """Time constant of the response when the load rises, s."""
    fall: float = 0.060
    """Time constant of the response when the load falls (hysteresis), s."""
    creep_share: float = 0.15
    """Share of the response that is slow."""
    creep: float = 0.4
    """Time constant of the slow response, s."""
    conductance: float = 2.2e-4
    """Conductance at a response of 1 N, in S / N^0.85."""
    exponent: float = 0.85
    leak: float = 2.0e-5
    """Conductance of an unloaded taxel, S."""
    resistor: float = 4700.0
    """Resistor of the divider, ohm."""
    crosstalk: float = 0.04
    """Share of the conductance of the neighbour in the same row that a reading includes."""
    noise: float = 0.004
    """RMS of the noise at the converter, V."""


#: Ideal force array, better than any real one: sensitive, fast and without creep.
OPTIMISTIC = VelostatParameters(threshold=0.0, rise=0.005, fall=0.010, creep_share=0.0)
