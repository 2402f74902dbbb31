"""Position sensor of the twin's drives."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, ClosingSpeed
from firstcontact.signal import closing_speed
from firstcontact.twin._mechanics import DRIVE_SPEED

#: Samples between two positions: about 200 Hz.
EVERY = 25
#: Standard deviation of a position at the fingertip, m: 0.06 degrees of a finger of 0.1 m.
NOISE = 1e-4
#: Number of past positions that are kept in memory: those of 0.5 s.
REMEMBERED = 100


class Positions:
    """Position sensor of the drives: it gives the mean position of both fingertips, with noise."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._travel = 0.0
        self._samples: deque[tuple[int, float]] = deque(maxlen=REMEMBERED)

    def add(self, motion: NDArray[np.float64], first_sample: int) -> None:
        """Measure and store positions while the fingers move."""
        travel = self._travel + np.cumsum(motion[..., DRIVE_SPEED].mean(axis=1)) / FINGERTIP_RATE
        for place in range(EVERY - 1, len(travel), EVERY):
            position = float(travel[place]) + NOISE * float(self._rng.standard_normal())
            self._samples.append((first_sample + place, position))
        self._travel = float(travel[-1])

    def speed(self, sample: int) -> ClosingSpeed | None:
        """Return the closing speed before a contact at this sample; None if it is unknown."""
        if not self._samples:
            return None
        samples, positions = zip(*self._samples, strict=True)
        return closing_speed(np.array(samples) / FINGERTIP_RATE, positions, sample / FINGERTIP_RATE)
