"""Steady state: mean and sigma of the motor's noise, as training code measures it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: A later steady state counts if its sigma is below this share of the earlier one.
QUIETER = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class SteadyState:
    """Mean and sigma of each vibration channel before any contact, shape (fingers,)."""

    mean: NDArray[np.float64]
    sigma: NDArray[np.float64]

    @classmethod
    def measure(cls, quiet: NDArray[np.float64]) -> SteadyState:
        """Return the steady state in ``quiet``, samples of shape (samples, fingers)."""
        # A range detects constant channels exactly. The standard deviation rounds.
        sigma = np.where(np.ptp(quiet, axis=0) > 0.0, quiet.std(axis=0), 0.0)
        return cls(quiet.mean(axis=0), sigma)

    @property
    def alive(self) -> NDArray[np.bool_]:
        """Mask of channels that vary. The others are unplugged or saturated."""
        return self.sigma > 0.0

    def is_louder_than(self, later: SteadyState) -> NDArray[np.bool_]:
        """Return a mask of the channels that a later steady state shows clearly quieter."""
        return np.asarray(later.alive & (later.sigma < QUIETER * self.sigma))

    def normalise(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the difference from the mean in sigmas; 0 for constant channels."""
        scale = np.where(self.alive, self.sigma, 1.0)
        return np.where(self.alive, (x - self.mean) / scale, 0.0)
