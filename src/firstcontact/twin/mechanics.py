"""Mechanics of a pinch and their nominal parameters, integrated with a fixed fine step.

Each finger is a chain drive - link - phalanx - mount - board - pad - skin. The skin meets a face of
the object (Hertz contact with two Maxwell arms, behind the wall of a hollow object). The two faces
are joined by the bulk and held by a clamp. The force through the mount drives the piezo disc. All
motion is along the closing direction.

The contact times are given, not the distances from the fingers to the object. A finger has no
effect before it touches. So each face of the object is placed where the finger of that face is at
the given time.

The loop over time is compiled: ``twin/c/mechanics.c``. ``docs/reference/twin-parameters.md`` states
the source of each number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.board import DIVIDER_OHM, PIN_OHM, ROW_OHM
from firstcontact.core.installation import load_compiled
from firstcontact.core.physics import contact_modulus, gent_modulus, hertz_stiffness
from firstcontact.twin.pad import PadParameters


class FingerParameters(NamedTuple):
    """Parameters of one finger, from its drive to its skin. SI units."""

    speed: float = 0.13
    """Closing speed of a fingertip, m/s: 5 cm in 0.4 s. Prosthetic hands close fully in 0.37 to 1 s
    [1]."""
    drive_mass: float = 0.45
    """Inertia of motor and gears, as an equivalent mass at the fingertip, kg: a rotor of 0.067 g
    cm² behind gears of 657:1, at 80 mm."""
    speed_gain: float = 250.0
    """Gain of the drive's speed loop, N s/m. A third of ``speed`` gives ``drive_force``."""
    drive_force: float = 12.0
    """Stall force of a prosthetic finger, N."""
    link_stiffness: float = 2.5e3
    """Stiffness of gears and linkage between drive and phalanx, N/m: both resonate at 59 Hz."""
    link_damping: float = 3.0
    """Damping of gears and linkage, N s/m: 22 % of critical damping."""
    phalanx_mass: float = 0.018
    """Mass of the end of the finger with its mount of PETG, kg."""
    mount_stiffness: float = 4.2e5
    """Stiffness of the screwed mount under the board, N/m: phalanx and board resonate at 2.25
    kHz."""
    mount_damping: float = 2.6
    """Damping of the mount, N s/m: 4 % of critical damping, as for a screwed plastic part."""
    board_mass: float = 0.0021
    """Mass of the board, kg: 0.9 g for 20 × 15 mm (paper) of FR4, and 1.2 g for disc and wires."""
    pad_stiffness: float = PadParameters().stiffness
    """Stiffness of the dimples below a touch, N/m: finite elements of the drawn pad."""
    pad_stiffening: float = PadParameters().stiffening
    """Cubic term of the dimples' stiffness, N/m³: they are flat at 0.8 mm, and the full area
    carries the force."""
    pad_arm_stiffness: float = PadParameters().arm_stiffness
    """Stiffness of the pad's Maxwell arm, N/m: half of the stiffness, as silicone loses tens of
    percent."""
    pad_relaxation: float = 1.2e-3
    """Relaxation time of this arm, s: most loss is near 130 Hz."""
    pad_damping: float = PadParameters().damping
    """Remaining loss of the pad at high frequency, N s/m."""
    pad_confinement: float = 0.0
    """Compliance that a rigid back right behind the pad takes from the contact, m/N; 0 for a pad on
    dimples. :func:`firstcontact.twin.pad.confinement` computes it."""
    skin_mass: float = 0.00055
    """Mass of the pad's front, kg: half of the pad (paper) at 1.1 g/cm³, rounded up."""
    pad_modulus: float = 4.43e6
    """Young's modulus of the pad, Pa: 65 Shore A (paper) by Gent's formula [2]."""
    tip_radius: float = 0.010
    """Radius of the fingertip at the contact, m."""
    piezo_volts_per_newton: float = 0.0963
    """Open-circuit voltage of the disc per newton, V/N: PZT-5A, 10 mm (paper) and 0.2 mm, in
    silicone. Mean of the six dimples."""
    piezo_time_constant: float = 2.8e-3
    """Time constant of disc and amplifier, s: 5.9 nF into 470 kΩ."""
    gain: float = 7.4
    """Gain of the amplifier: uses the converter's range without clipping."""
    buffer_cutoff: float = 1.8e3
    """Cutoff of the amplifier, a first-order low-pass filter, Hz: below half of 4936 Hz."""


class ObjectParameters(NamedTuple):
    """Parameters of the object: two faces, the bulk between them, and its support. SI units."""

    modulus: float = 1.0e6
    """Young's modulus in a slow indentation, Pa: by Gent's formula [2] from the Shore A reading
    (paper)."""
    radius: float = 1.0e3
    """Radius of the surface at the contact, m. 1000 m is flat."""
    face_mass: float = 0.095
    """Mass that moves with each face, kg: half of the object's mass."""
    bulk_stiffness: float = 1.4e5
    """Stiffness between the faces, N/m: that of a column, modulus × area / length."""
    bulk_damping: float = 30.0
    """Damping between the faces, N s/m: loss factor × √(stiffness × mass / 4)."""
    clamp_stiffness: float = 150.0
    """Stiffness of the support, N/m: a loose clamp, in which a block swings at 4 Hz."""
    clamp_damping: float = 1.5
    """Damping of the support, N s/m."""
    dent_stiffness: float = math.inf
    """Stiffness of a hollow object's wall against a dent, N/m: Reissner's shell [3], stiffer by the
    fast arm."""
    arm_share: float = 0.25
    """Stiffness of the contact's fast Maxwell arm, as a share of the slow contact stiffness: twice
    the loss factor, times 1 + ``slow_share``."""
    arm_relaxation: float = 4.0e-3
    """Relaxation time of the fast arm, s: most loss is near 40 Hz."""
    slow_share: float = 0.0
    """Stiffness of the contact's slow arm: what the stiffness loses from 10 ms to a durometer's
    second."""
    slow_relaxation: float = 0.1
    """Relaxation time of the slow arm, s: the middle of these two decades."""

    @classmethod
    def solid(
        cls, shore_a: float, mass: float, bulk: float, loss: float, slow: float = 0.0
    ) -> ObjectParameters:
        """Return a solid object from its Shore A, mass, kg, bulk stiffness, N/m, and losses.

        ``loss`` is the loss factor within milliseconds. ``slow`` is the share of the stiffness that
        relaxes between about 10 ms and the second after which a durometer is read.
        """
        quick_bulk = bulk * (1 + slow)
        return cls(
            modulus=gent_modulus(shore_a),
            face_mass=mass / 2,
            bulk_stiffness=quick_bulk,
            bulk_damping=loss * math.sqrt(quick_bulk * mass / 4),
            arm_share=2 * loss * (1 + slow),
            slow_share=slow,
        )

    def stiffened(self, factor: float) -> ObjectParameters:
        """Return the object with its modulus multiplied by ``factor``."""
        return self._replace(
            modulus=self.modulus * factor,
            bulk_stiffness=self.bulk_stiffness * factor,
            dent_stiffness=self.dent_stiffness * factor,
        )


#: Share of the pad's own arm at the contact, as that of a block.
PAD_ARM = ObjectParameters().arm_share


class Timing(NamedTuple):
    """Times of both contacts of a pinch, s from the first sample."""

    first: float
    second: float
    first_is_index: bool


class VelostatParameters(NamedTuple):
    """Parameters of one fingertip's force array. SI units."""

    threshold: float = 0.30
    """Least force on a taxel that raises the conductance, N."""
    rise: float = 0.030
    """Time constant of the response when the force rises, s."""
    fall: float = 0.060
    """Time constant of the response when the force falls, s: slower (hysteresis)."""
    creep_share: float = 0.15
    """Share of the response that comes late [12, 13]."""
    creep: float = 0.4
    """Time constant of the late response, s."""
    conductance: float = 2.5e-5
    """Conductance at 1 N, S/N^exponent: geometric mean of the drawn range [11]."""
    exponent: float = 0.85
    """Exponent of the conductance over the force: mean of the drawn range [11]."""
    leak: float = 2.0e-6
    """Conductance without force, S: at most 2.3 µS [11]."""
    resistor: float = DIVIDER_OHM
    """Resistor of a column's divider, Ω: half of the supply at 2 N on a taxel."""
    row: float = ROW_OHM + PIN_OHM
    """Resistance of a row, Ω: a resistor of 330 Ω, and the pin that drives it, 23 Ω (data sheet of
    the i.MX RT1060)."""
    noise: float = 0.004
    """RMS of the noise at the converter, V: about one converter step."""


#: States of a finger: position and speed of drive, phalanx, board and skin; elongation of the
#: Maxwell arms of pad and contact (fast, slow); voltage that the piezo has lost by leakage;
#: buffer's output.
FINGER_STATES = 13
#: Two fingers, then position and speed of the object's two faces.
STATES = 2 * FINGER_STATES + 4
#: Number of values that :func:`integrate_all` writes per sample and finger.
OUTPUTS = 5
BUFFER, CONTACT_FORCE, INDENTATION, FACE, DRIVE_SPEED = range(OUTPUTS)

_Vector = NDArray[np.float64]


class Piece(NamedTuple):
    """Arguments of the compiled function that integrates the motion of a pinch, or of a part.

    The function also writes its results into them.
    """

    index_finger: FingerParameters
    thumb: FingerParameters
    target: ObjectParameters
    stiffness: _Vector
    """:func:`contact_stiffness` of each finger, shape (2,)."""
    touch: _Vector
    """Contact times of index and thumb, s. A finger whose time is after the end never touches."""
    times: _Vector
    """Sampling instants, s, increasing. The state starts at ``times[0]``."""
    noise: _Vector
    """Noise force on each phalanx, N, shape (2, points), from t = 0."""
    noise_dt: float
    """Time between two points of the noise, s."""
    substeps: int
    """Integration steps per sampling interval once a finger is about to touch. Half as many steps
    are used before."""
    speeds: _Vector
    """Reference speeds of both drives in each sampling interval, m/s, shape (samples - 1, 2). One
    row if there is one sample."""
    motor_force: float
    """Largest force of each motor, N."""
    back_damping: float
    """Damping of a drive that is pushed backwards while it should close or stand still, N s/m."""
    full_speed: float
    """Drive speed at which motor noise has its full strength, m/s. Below this speed the noise is
    proportional to the speed. 0 means full strength at any speed."""
    limit: float
    """Contact force at which the object breaks, N. The integration stops at the first sample with
    a larger force."""
    calm: float
    """Time from the second contact until fewer steps are enough, s."""
    calm_steps: int
    """Integration steps per sampling interval after that time."""
    x: _Vector
    """State at ``times[0]``, shape (30,), changed in place to the state at ``times[-1]``."""
    gap: _Vector
    """Positions of the object's faces when index and thumb touched, m, shape (2,), changed in
    place. NaN before a contact: then ``touch`` decides when the finger touches. A number before a
    contact fixes the position of the face: then the finger touches when it gets there."""
    touched: _Vector
    """First sampling instants at which index and thumb touched, s, shape (2,); NaN before. Changed
    in place."""
    out: _Vector
    """Array for the output, shape (samples, 2, 5): voltage of the buffer (V), contact force (N),
    indentation (m), displacement of the face (m), drive speed (m/s). The indentation is negative
    without contact, and NaN while the position of the face is unknown."""


def contact_stiffness(p: FingerParameters, o: ObjectParameters) -> float:
    """Return the Hertz stiffness of a fingertip against an object, N/m^1.5."""
    radius = 1 / (1 / p.tip_radius + 1 / o.radius)
    return hertz_stiffness(contact_modulus(p.pad_modulus, o.modulus), radius)


def contact_arms(p: FingerParameters, o: ObjectParameters) -> ObjectParameters:
    """Return the object with the relaxation of its contact with the pad.

    The pad deforms at the contact, too, and its silicone relaxes as a block does. So a contact with
    fruit relaxes less than the fruit, and a contact with a block as much as the block. The
    strengths are shares of the contact's stiffness.
    """

    def stiffness(pad: float, target: float) -> float:
        return contact_modulus(pad * p.pad_modulus, target * o.modulus)

    slowest, slow = stiffness(1, 1), 1 + o.slow_share
    middle, all_arms = stiffness(1, slow), stiffness(1 + PAD_ARM, slow + o.arm_share)
    fast_share = (all_arms - middle) / slowest
    return o._replace(arm_share=fast_share, slow_share=middle / slowest - 1)


#: Function that integrates pieces of different pinches, side by side in the lanes of a vector unit.
#: It returns the number of samples of each.
integrate_all: Callable[[list[Piece]], list[int]] = load_compiled(
    "firstcontact.twin._compiled"
).integrate_all
