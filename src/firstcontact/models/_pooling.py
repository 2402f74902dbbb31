"""Several pinches of one object as one answer."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from firstcontact.models._interval import SHORE_A

#: Part of a pinch's error that the next pinch of the same object has, too: what specimen, label,
#: session and rig contribute. Told as a standard deviation in those of the whole error. Measured
#: by ``firstcontact pretrain`` on random rigs that nothing was learned from, 5 pinches of each
#: thing in one session ("same object" in the card of the network): 0.88 to 0.89 at 3 to 15 ms.
SHARED = 0.89


@dataclass(frozen=True, slots=True)
class Combined:
    """One answer from several pinches.

    Parameters
    ----------
    value
        Shore A.
    low, high
        Ends of the interval, Shore A.
    half_width
        Of the interval, before it is cut off at the ends of the scale, Shore A.
    pinches
        How many it is made from.
    """

    value: float
    low: float
    high: float
    half_width: float
    pinches: int


def combine(values: Sequence[float], half_widths: Sequence[float]) -> Combined:
    """Weigh pinches of one object by how sure each is.

    Weights are inverse to the squares of the half widths. The error of each pinch is taken as
    two independent parts: one that all pinches of the object share, ``SHARED`` of the whole, and
    one of its own. Only the latter shrinks with the number of pinches, so that the interval
    never becomes narrower than ``SHARED`` of a single pinch's.

    Parameters
    ----------
    values, half_widths
        Of the pinches, at least one, Shore A; the latter above 0.
    """
    value, half = np.asarray(values, np.float64), np.asarray(half_widths, np.float64)
    weight = half**-2
    mean = float(weight @ value / weight.sum())
    n = len(value)
    single = n / weight.sum()
    width = float(np.sqrt(single * (SHARED**2 + (1 - SHARED**2) / n)))
    least, most = SHORE_A
    low, high = (min(max(mean + sign * width, least), most) for sign in (-1, 1))
    return Combined(mean, low, high, width, n)
