"""How the support under a pinched object goes away."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE

#: The support begins to go so long after the first contact unless something else is asked for, s.
LIFT = 0.45


@dataclass(frozen=True, slots=True)
class Lift:
    """The support's share of the weight falls evenly from 1 to 0.

    Parameters
    ----------
    after
        From the first contact to the instant at which the support begins to go, s.
    over
        Time in which it goes, s; 0 for an abrupt lift.

    Raises
    ------
    ValueError
        A time that is negative or no number.
    """

    after: float = LIFT
    over: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.after < math.inf and 0 <= self.over < math.inf):
            raise ValueError(f"{self}: use times from 0 s on")

    @property
    def begin(self) -> int:
        """Samples from the first contact to the first one at which something hangs."""
        return round(self.after * FINGERTIP_RATE)

    @property
    def samples(self) -> int:
        """Samples from the first contact to the first one at which all of it hangs."""
        return round((self.after + self.over) * FINGERTIP_RATE)

    def hanging(self, first: int, samples: int) -> NDArray[np.float64]:
        """Share of the weight that the support does not carry.

        Parameters
        ----------
        first
            Samples from the first contact to the first that is asked for; may be negative.
        samples
            How many are asked for.

        Returns
        -------
        ndarray
            Shape (samples,), 0 to 1.
        """
        since = np.arange(first, first + samples) - self.begin
        ramp = self.samples - self.begin
        if ramp == 0:
            return (since >= 0).astype(np.float64)
        return np.clip(since / ramp, 0.0, 1.0)
