"""Model of the sound of a slip: patches of the pad stick to the object and release.

**Modelled, not measured on any fingertip.** ``docs/reference/twin-parameters.md`` separates sourced
numbers from assumptions. The loudness of a slip depends mainly on ``coupling``, which was not
measured.

The front of the pad is a row of patches. Each patch is a mass on the pad's shear stiffness. It is
pressed against the object with its share of the contact force. A patch sticks until the pull of the
object exceeds static friction. It then releases, swings back and sticks again.

The object moves as in :func:`firstcontact.twin._outcome.slide`. Before the slip, its weight shears
the pads. A force along the pad acts on the piezo as a normal force does, times ``coupling``.
"""

from __future__ import annotations

import copy
import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, GRAVITY
from firstcontact.twin._compiled import compiled
from firstcontact.twin._parameters import FingerParameters

#: Steps per sampling interval.
STEPS = 20
#: Number of drawn friction values along the path of each patch. They repeat after that.
PLACES = 64
_Vector = NDArray[np.float64]


class SlipParameters(NamedTuple):
    """Parameters of a sliding pad. SI units."""

    patches: int = 12
    """Number of independent patches."""
    stiffness: float = 15e3
    """Shear stiffness of the pad, N/m."""
    mass: float = 0.00055
    """Mass of the pad's front, which moves with the skin, kg."""
    damping: float = 0.15
    """Damping of the pad's front, as a share of the critical damping."""
    ratio: float = 1.5
    """Ratio of static to kinetic friction."""
    weakening: float = 0.018
    """Sliding speed at which friction has fallen by 63 % of the way to kinetic friction, m/s."""
    scatter: float = 0.15
    """Standard deviation of ln(friction) along the object, for each patch."""
    grain: float = 1e-4
    """Distance between drawn friction values along the object, m."""
    coupling: float = 0.1
    """Piezo voltage per newton along the pad, divided by the voltage per newton normal to it."""


@compiled
def _slide_patches(
    normal: _Vector, speed: _Vector, pull: _Vector, mass: float, friction: float,
    p: SlipParameters, finger: FingerParameters, factors: _Vector, patches: _Vector,
    state: _Vector, out: _Vector,
) -> None:  # fmt: skip
    """Advance the patches of one finger by the next samples.

    ``patches``, shape (patches, 4), has offset, speed, sticking flag and path position of each
    patch. ``state``, shape (7,), has seven values: the last normal force, the last sliding speed,
    the last pull of the object's weight, offset and speed of the object as the pads shear, voltage
    of the piezo, voltage of the buffer. Both arrays are changed in place.
    """
    dt = 1.0 / (FINGERTIP_RATE * STEPS)
    k, m = p.stiffness / p.patches, p.mass / p.patches
    c = 2.0 * p.damping * math.sqrt(k * m)
    shear = 2.0 * p.stiffness / mass  # both pads hold the object
    loss = 2.0 * p.damping * math.sqrt(shear)
    # A light object swings faster than a step can follow, so use its equilibrium position.
    stiff = shear * dt * dt > 0.04
    volts_per_newton = p.coupling * finger.piezo_volts_per_newton
    leak = 1.0 - math.exp(-dt / finger.piezo_time_constant)
    open_buffer = 1.0 - math.exp(-2.0 * math.pi * finger.buffer_cutoff * dt)
    for i in range(normal.size):
        for step in range(STEPS):
            part = (step + 1.0) / STEPS
            press = max(state[0] + part * (normal[i] - state[0]), 0.0) / p.patches
            slides = state[1] + part * (speed[i] - state[1])
            load = state[2] + part * (pull[i] - state[2])
            if stiff:
                wanted = load / p.stiffness
                state[4] = (wanted - state[3]) / dt
                state[3] = wanted
            else:
                state[4] += (shear * (load / p.stiffness - state[3]) - loss * state[4]) * dt
                state[3] += state[4] * dt
            surface = slides + state[4]
            along = 0.0
            for j in range(p.patches):
                place = int(patches[j, 3])
                between = patches[j, 3] - place
                left, right = factors[j, place % PLACES], factors[j, (place + 1) % PLACES]
                static = friction * (left + between * (right - left)) * press
                back = k * patches[j, 0] + c * patches[j, 1]
                if patches[j, 2] > 0.0:
                    patches[j, 1] = surface
                    patches[j, 0] += surface * dt
                    back = k * patches[j, 0] + c * surface
                    if abs(back) > static:
                        patches[j, 2] = 0.0
                else:
                    off = surface - patches[j, 1]
                    kinetic = static / p.ratio
                    drag = kinetic + (static - kinetic) * math.exp(-abs(off) / p.weakening)
                    previous = off
                    patches[j, 1] += ((drag if off > 0.0 else -drag) - back) / m * dt
                    patches[j, 0] += patches[j, 1] * dt
                    patches[j, 3] += abs(off) * dt / p.grain
                    off = surface - patches[j, 1]
                    if off * previous <= 0.0 and abs(k * patches[j, 0]) <= static:
                        patches[j, 2] = 1.0
                        patches[j, 1] = surface
                along += back
            pressed = volts_per_newton * along
            state[5] += leak * (pressed - state[5])
            state[6] += open_buffer * (finger.gain * (pressed - state[5]) - state[6])
        state[0], state[1], state[2] = normal[i], speed[i], pull[i]
        for j in range(3, 7):
            if abs(state[j]) < 1e-30:  # numbers too small to be normal are slow
                state[j] = 0.0
        out[i] = state[6]


class SlipSound:
    """Source of the slip sound in both piezos, piece by piece.

    Parameters
    ----------
    fingers
        Index and thumb.
    mass, friction
        Mass of the object, kg, and its coefficient of friction against each finger.
    parameters
        Parameters of the pads.
    rng
        Random generator for the static friction. Use a separate generator, so that the slip sound
        does not change other random numbers.
    """

    def __init__(
        self,
        fingers: tuple[FingerParameters, FingerParameters],
        mass: float,
        friction: float,
        parameters: SlipParameters,
        rng: np.random.Generator,
    ) -> None:
        self._fingers, self._mass, self._friction = fingers, mass, friction
        self._p = parameters
        shape = (2, parameters.patches, PLACES)
        self._factors = np.exp(parameters.scatter * rng.standard_normal(shape))
        self._patches = np.zeros((2, parameters.patches, 4))
        self._patches[..., 2] = 1.0
        self._state = np.zeros((2, 7))

    def hear(self, forces: _Vector, speeds: _Vector, hanging: _Vector) -> _Vector:
        """Return the voltage that the slip sound adds to the signal of each buffer.

        Parameters
        ----------
        forces
            Contact forces, N, shape (samples, 2).
        speeds
            Sliding speed of the object, m/s, shape (samples,).
        hanging
            Share of the weight that the support does not carry, shape (samples,).

        Returns
        -------
        ndarray
            Voltage, V, shape (samples, 2).
        """
        out = np.empty((2, len(forces)))
        pull = 0.5 * self._mass * GRAVITY * hanging
        for f, finger in enumerate(self._fingers):
            _slide_patches(
                np.ascontiguousarray(forces[:, f]), speeds, pull, self._mass, self._friction,
                self._p, finger, self._factors[f], self._patches[f], self._state[f], out[f],
            )  # fmt: skip
        return out.T

    def fork(self) -> Self:
        """Return an independent copy in the same state."""
        other = copy.copy(self)
        other._patches, other._state = self._patches.copy(), self._state.copy()
        return other
