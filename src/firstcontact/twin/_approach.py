"""Contact times of fingers that are still closing."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.twin._parameters import Timing


class Approach:
    """Contact times of two fingers, each of which touches after a fixed distance.

    The distance is the one that a finger covers until its drawn contact time at the drawn speed. At
    that speed it touches at that time.

    Parameters
    ----------
    timing
        Drawn contact times.
    begin
        Instant from which these times count, s.
    nominal
        Drawn speed, the mean of both fingers, m/s.
    speed
        Initial speed, m/s.

    Attributes
    ----------
    touch
        Contact times of index and thumb, s, shape (2,); infinite for a hand that does not close.
    """

    def __init__(self, timing: Timing, begin: float, nominal: float, speed: float) -> None:
        first, second, first_is_index = timing
        drawn = np.array([first, second] if first_is_index else [second, first]) + begin
        self.touch: NDArray[np.float64] = drawn if speed == nominal else np.full(2, math.inf)
        self._distance_left = nominal * drawn
        self._since = 0.0

    def turn(self, old: float, new: float, now: float, touching: NDArray[np.bool_]) -> None:
        """Continue at another speed.

        Parameters
        ----------
        old, new
            Old and new speed, m/s.
        now
            Present instant, s.
        touching
            Mask of the fingers that have touched.
        """
        self._distance_left -= old * (now - self._since)
        self._since = now
        contact_times = now + self._distance_left / new if new > 0 else math.inf
        self.touch = np.where(touching, self.touch, contact_times)
