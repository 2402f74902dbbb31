"""Model of the sound of a slip: patches of the pad stick to the object and release.

**Modelled, not measured on any fingertip.** ``docs/reference/twin-parameters.md`` separates sourced
numbers from assumptions. The loudness of a slip depends mainly on ``coupling``, which was not
measured.

The front of the pad is a row of patches. Each patch is a mass on the pad's shear stiffness. It is
pressed against the object with its share of the contact force. A patch sticks until the pull of the
object exceeds static friction. It then releases, swings back and sticks again.

The object moves as in :func:`firstcontact.twin.outcome.slide`. Before the slip, its weight shears
the pads. A force along the pad acts on the piezo as a normal force does, times ``coupling``.
"""

from __future__ import annotations

import copy
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.installation import load_compiled
from firstcontact.core.physics import GRAVITY
from firstcontact.twin.mechanics import FingerParameters

#: Number of drawn friction values along the path of each patch. They repeat after that.
PLACES = 64
_Vector = NDArray[np.float64]
_kernels = load_compiled("firstcontact.twin._compiled")


class SlipParameters(NamedTuple):
    """Physical parameters of a pad that slides. SI units."""

    patches: int = 12
    """Number of patches that release separately: structured PDMS slips in small events [8]."""
    stiffness: float = 15e3
    """Stiffness along the pad, N/m: a tenth of the solid pad's 1.5e5 N/m (paper)."""
    mass: float = 0.00055
    """Mass of the pad's front, as ``skin_mass``, kg: resonates with the stiffness at 830 Hz."""
    damping: float = 0.15
    """Loss factor: silicone loses tens of percent."""
    ratio: float = 1.5
    """Static over kinetic friction: 2.1 and 1.4 in a published simulation [9]."""
    weakening: float = 0.018
    """Speed at which friction has fallen by 63 % of the way to kinetic friction, m/s: of the order
    of 1/55 m/s."""
    scatter: float = 0.15
    """Standard deviation of ln(friction) between patches: ± 10 % of the friction of all twelve
    [10]."""
    grain: float = 1e-4
    """Distance along the object between places that differ in friction, m."""
    coupling: float = 0.1
    """Piezo signal of a force along the pad, relative to that of a force into it. The most
    important number."""


class SlipSound:
    """Simulation of the sound of slips in both piezos, which runs piece by piece."""

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
        # Offset, speed, sticking flag and path position of each patch.
        self._patches = np.zeros((2, parameters.patches, 4))
        self._patches[..., 2] = 1.0
        # Last normal force, sliding speed and pull of the weight; offset and speed of the object
        # as the pads shear; voltages of piezo and buffer.
        self._state = np.zeros((2, 7))

    def hear(self, forces: _Vector, speeds: _Vector, hanging: _Vector) -> _Vector:
        """Return the voltage that slips add to each piezo's signal, V.

        ``forces`` are contact forces, N, ``speeds`` those of the sliding object, m/s, and
        ``hanging`` the share of the weight on the hand.
        """
        out = np.empty((2, len(forces)))
        pull = 0.5 * self._mass * GRAVITY * hanging
        for f, finger in enumerate(self._fingers):
            _kernels.slide_patches(
                np.ascontiguousarray(forces[:, f]), speeds, pull, self._mass, self._friction,
                self._p, finger, self._factors[f], self._patches[f], self._state[f], out[f],
            )  # fmt: skip
        return out.T

    def fork(self) -> Self:
        other = copy.copy(self)
        other._patches, other._state = self._patches.copy(), self._state.copy()
        return other
