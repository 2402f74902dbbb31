"""When the fingers touch that are on their way."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.twin._parameters import Timing


class Approach:
    """A finger touches when it has travelled a way that is fixed.

    The way is the one to its drawn instant at the drawn speed; at that speed all along, it
    touches at that instant.

    Parameters
    ----------
    timing
        The drawn instants.
    begin
        Instant from which these count, s.
    nominal
        Drawn speed, the mean of both fingers, m/s.
    speed
        Speed at first, m/s.

    Attributes
    ----------
    touch
        Instants at which index and thumb will touch, s, shape (2,); infinite for a hand that
        does not close.
    """

    def __init__(self, timing: Timing, begin: float, nominal: float, speed: float) -> None:
        first, second, first_is_index = timing
        drawn = np.array([first, second] if first_is_index else [second, first]) + begin
        self.touch: NDArray[np.float64] = drawn if speed == nominal else np.full(2, math.inf)
        self._to_go = nominal * drawn
        self._since = 0.0

    def turn(self, before: float, after: float, now: float, there: NDArray[np.bool_]) -> None:
        """Go on at another speed.

        Parameters
        ----------
        before, after
            The speeds, m/s.
        now
            The instant, s.
        there
            Which fingers have touched.
        """
        self._to_go -= before * (now - self._since)
        self._since = now
        coming = now + self._to_go / after if after > 0 else math.inf
        self.touch = np.where(there, self.touch, coming)
