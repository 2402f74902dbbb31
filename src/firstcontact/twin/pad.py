"""Stiffness of the fingertip's pad at the place of a touch, from the pad's drawing.

Twin, drawings and build page read the dimples' numbers here; those of the skin are in
``FingerParameters``. ``hardware/pad.py`` computes them with finite elements, and ``tests/hardware``
compares them.

A touch of 2 to 3 mm bends the pad between its dimples. It loads those next to it, not all six.
"""

from __future__ import annotations

from typing import NamedTuple

from firstcontact.core.physics import POISSON

#: Stiffness of a pad that is pressed all over, N/m: on six dimples, and without dimples (paper).
ON_DIMPLES, SOLID = 5.0e4, 4.4e5


class PadParameters(NamedTuple):
    """Pad below a touch as a spring, with its relaxing part and its damping. SI units.

    The defaults are those of the drawn pad. The stiffness is the harmonic mean over the pad,
    between dimples that stick to the sheet and that slide.
    """

    stiffness: float = 1.43e4
    stiffening: float = 1.74e11
    arm_stiffness: float = 7.2e3
    damping: float = 0.43

    def scaled(self, factor: float) -> PadParameters:
        """Return the pad at a place where it is stiffer by this factor."""
        return PadParameters(*(factor * value for value in self))


def confinement(modulus: float, thickness: float) -> float:
    """Return by how much a rigid back lowers the compliance of a thin layer, m/N.

    ``modulus`` is in Pa, ``thickness`` in m.
    """
    return 0.11 / (modulus / (2 * (1 + POISSON)) * thickness)
