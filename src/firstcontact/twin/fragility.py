"""How much force an object bears."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: What is left of the stiffness of what is broken.
CRUSHED = 0.02


@dataclass(frozen=True, slots=True)
class Fragility:
    """The force at which one finger breaks the object, a Weibull's.

    Parameters
    ----------
    scale
        63 of 100 break at less, N.
    modulus
        Weibull's: the higher, the less scatter.
    """

    scale: float
    modulus: float

    def draw(self, rng: np.random.Generator) -> float:
        """The limit of one object, N."""
        return self.scale * float(rng.weibull(self.modulus))
