"""Removal of the support under a pinched object."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE

#: Default time from the first contact to the beginning of the lift, s.
LIFT = 0.45


@dataclass(frozen=True, slots=True)
class Lift:
    """Lift of an object: the support's share of the weight falls linearly from 1 to 0.

    Parameters
    ----------
    delay
        Time from the first contact to the beginning of the lift, s.
    duration
        Duration of the lift, s; 0 for an abrupt one.

    Raises
    ------
    ValueError
        A time is negative or not a number.
    """

    delay: float = LIFT
    duration: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.delay < math.inf and 0 <= self.duration < math.inf):
            raise ValueError(f"a time of {self} is negative: use 0 s or more")

    @property
    def begin(self) -> int:
        """Number of samples from the first contact to the beginning of the lift."""
        return round(self.delay * FINGERTIP_RATE)

    @property
    def samples(self) -> int:
        """Number of samples from the first contact to the end of the lift."""
        return round((self.delay + self.duration) * FINGERTIP_RATE)

    def hanging(self, first: int, samples: int) -> NDArray[np.float64]:
        """Return the share of the weight that the support does not carry.

        Parameters
        ----------
        first
            Number of samples from the first contact to the first returned share; may be negative.
        samples
            Number of returned shares.

        Returns
        -------
        ndarray
            Shares from 0 to 1, shape (samples,).
        """
        since = np.arange(first, first + samples) - self.begin
        ramp = self.samples - self.begin
        if ramp == 0:
            return (since >= 0).astype(np.float64)
        return np.clip(since / ramp, 0.0, 1.0)
