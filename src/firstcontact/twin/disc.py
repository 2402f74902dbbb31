"""Voltage of the piezo disc per newton, for each place of the pad that is pressed.

Twin, circuit and build page read these numbers here. ``hardware/disc.py`` computes them with finite
elements, and ``tests/hardware`` compares them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

#: Open-circuit voltage per newton on the dimple of each taxel, V/N. Taxels 2 and 3 are in the
#: middle row, the others at the corners.
VOLTS_PER_NEWTON = np.array([0.0953, 0.0953, 0.0982, 0.0982, 0.0953, 0.0953])
#: Range of a factor on the four corners, by the thickness and stiffness of a hand's glue. Their
#: effect on all places alike is part of the spread of the gain.
CORNERS = (0.967, 1.018)
_IS_CORNER = np.array([True, True, False, False, True, True])


def volts_per_newton(shares: NDArray[np.float64], corners: float = 1.0) -> float:
    """Return the open-circuit voltage of the disc per newton on the pad, V/N.

    Parameters
    ----------
    shares
        Share of the force on each taxel, shape (6,).
    corners
        Factor on the values of the corners.
    """
    return float(shares @ np.where(_IS_CORNER, corners * VOLTS_PER_NEWTON, VOLTS_PER_NEWTON))
