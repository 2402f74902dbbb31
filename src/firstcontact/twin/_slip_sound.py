"""What a slip sounds like: patches of the pad that stick to the object and let go, one by one.

**Modelled, and not measured on any fingertip**: what of it has a source, and what is assumed, is in
``docs/reference/twin-parameters.md``. How loud a slip is depends above all on ``coupling``, which
nobody has measured.

The pad's front is so many patches side by side, each a mass on the pad's shear stiffness, pressed
against the object with its share of the contact force. A patch sticks until the object has pulled
it as far as static friction bears; it lets go, swings back, and sticks again. The object moves as
:func:`firstcontact.twin._outcome.slide` has it, and before that as far as its weight shears the
pads. The force along the pad reaches the piezo with a stated share of what a normal force would.
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
#: Friction at so many places of the way of each patch is drawn; then they come again.
PLACES = 64
_Vector = NDArray[np.float64]


class SlipParameters(NamedTuple):
    """A pad that slides. SI units."""

    patches: int = 12
    """That stick and let go by themselves."""
    stiffness: float = 15e3
    """Of the pad in shear, N/m."""
    mass: float = 0.00055
    """Front of the pad that moves along with the skin, kg."""
    damping: float = 0.15
    """Of that mass on that stiffness, share of critical."""
    ratio: float = 1.5
    """Static over kinetic friction."""
    weakening: float = 0.018
    """Speed at which friction has fallen by 1 - 1/e of the way to kinetic, m/s."""
    scatter: float = 0.15
    """Standard deviation of ln(friction) from place to place, of each patch."""
    grain: float = 1e-4
    """From place to place along the object, m."""
    coupling: float = 0.1
    """Volts of the piezo per newton along the pad, as a share of those per newton through it."""


@compiled(error_model="numpy")
def _slide_patches(
    normal: _Vector, speed: _Vector, pull: _Vector, mass: float, friction: float,
    p: SlipParameters, finger: FingerParameters, factors: _Vector, patches: _Vector,
    state: _Vector, out: _Vector,
) -> None:  # fmt: skip
    """Go on by one finger's next samples.

    ``patches`` has offset, speed, whether it sticks, and the place of each, shape (patches, 4);
    ``state`` the last normal force, sliding speed and pull, the object's shear offset and its
    speed, the piezo's leaked voltage and the buffer, shape (7,). Both are changed in place.
    """
    dt = 1.0 / (FINGERTIP_RATE * STEPS)
    k, m = p.stiffness / p.patches, p.mass / p.patches
    c = 2.0 * p.damping * math.sqrt(k * m)
    shear = 2.0 * p.stiffness / mass  # both pads hold the object
    loss = 2.0 * p.damping * math.sqrt(shear)
    # A light object swings faster than a step can follow: it is where it is pulled to.
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
                here, there = factors[j, place % PLACES], factors[j, (place + 1) % PLACES]
                static = friction * (here + between * (there - here)) * press
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
                    before = off
                    patches[j, 1] += ((drag if off > 0.0 else -drag) - back) / m * dt
                    patches[j, 0] += patches[j, 1] * dt
                    patches[j, 3] += abs(off) * dt / p.grain
                    off = surface - patches[j, 1]
                    if off * before <= 0.0 and abs(k * patches[j, 0]) <= static:
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
    """What either piezo hears of a slip, piece by piece.

    Parameters
    ----------
    fingers
        Index and thumb.
    mass, friction
        The object's, kg, and against either finger.
    parameters
        Of the pads.
    rng
        Where the static friction of each place comes from; one of its own, so that nothing that
        is drawn elsewhere changes.
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
        """Voltage at the buffers, to be added to that of everything else.

        Parameters
        ----------
        forces
            Contact forces, N, shape (samples, 2).
        speeds
            How fast the object slides, m/s, shape (samples,).
        hanging
            Share of its weight that no support carries, shape (samples,).

        Returns
        -------
        ndarray
            V, shape (samples, 2).
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
        """Another as it is now, to go on by itself."""
        other = copy.copy(self)
        other._patches, other._state = self._patches.copy(), self._state.copy()
        return other
