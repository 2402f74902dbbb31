"""Mechanics of a pinch, integrated with a fixed fine step.

Each finger is a chain drive - link - phalanx - mount - board - pad - skin. The skin meets a face of
the object (Hertz contact with a Maxwell arm and Hunt-Crossley loss). The two faces are joined by
the bulk and held by a clamp. The force through the mount drives the piezo disc. All motion is along
the closing direction.

The contact times are given, not the distances from the fingers to the object. A finger has no
effect before it touches. So each face of the object is placed where the finger of that face is at
the given time.

The loop over time is compiled: ``core/c/mechanics.c``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import contact_modulus, hertz_stiffness, kernels
from firstcontact.twin._parameters import FingerParameters, ObjectParameters

#: States of a finger: position and speed of drive, phalanx, board and skin; elongation of the
#: Maxwell arms of pad and contact; voltage that the piezo has lost by leakage; buffer's output.
FINGER_STATES = 12
#: Two fingers, then position and speed of the object's two faces.
STATES = 2 * FINGER_STATES + 4
#: Number of values that :func:`integrate_all` writes per sample and finger.
OUTPUTS = 5
BUFFER, CONTACT_FORCE, INDENTATION, FACE, DRIVE_SPEED = range(OUTPUTS)

_Vector = NDArray[np.float64]
_kernels = kernels()


class Piece(NamedTuple):
    """Pinch to integrate, or a piece of one."""

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
    """State at ``times[0]``, shape (28,), changed in place to the state at ``times[-1]``."""
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
    """Return the Hertz stiffness of the finger against the object, N/m^1.5."""
    radius = 1 / (1 / p.tip_radius + 1 / o.radius)
    return hertz_stiffness(contact_modulus(p.pad_modulus, o.modulus), radius)


def integrate_all(pieces: list[Piece]) -> list[int]:
    """Integrate pieces of different pinches, side by side in the lanes of a vector unit."""
    taken: list[int] = _kernels.integrate_all(pieces)
    return taken
