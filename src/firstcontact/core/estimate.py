"""What the system answers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Estimate:
    """A stiffness.

    Parameters
    ----------
    shore_a
        Shore A.
    duration
        Length of the window it was read from, s.
    seconds
        Time the computation took, s.
    """

    shore_a: float
    duration: float
    seconds: float
