"""Pooled prediction from several pinches of one object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from firstcontact.models._interval import SHORE_A

#: Share of a pinch's error that all pinches of the object have in common, as a standard deviation:
#: the contribution of specimen, label, session and rig. Measured by ``firstcontact pretrain`` on
#: random rigs outside the training, with 5 pinches of each object in one session ("same object" in
#: the network's card): 0.88 to 0.89 at 3 to 15 ms.
SHARED = 0.89


@dataclass(frozen=True, slots=True)
class Combined:
    """Pooled prediction from several pinches of one object."""

    value: float
    low: float
    high: float
    half_width: float
    pinches: int


def combine(values: Sequence[float], half_widths: Sequence[float]) -> Combined:
    """Average the predictions for pinches of one object, weighted by precision.

    Weights are inverse squares of the half widths. The error of each pinch has two independent
    parts. One part, a share ``SHARED`` of the half width, is common to all pinches of the object.
    Only the other part shrinks with the number of pinches. So the interval never becomes narrower
    than ``SHARED`` times the interval of a single pinch.

    Parameters
    ----------
    values, half_widths
        Predictions and half widths (above 0) of at least one pinch, Shore A.
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
