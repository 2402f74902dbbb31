"""Comparison of sampling rates."""

from __future__ import annotations

#: Largest relative difference between the clocks of two devices of one kind.
TOLERANCE = 0.01


def is_same_rate(rate: float, other: float) -> bool:
    """Return True if two rates (Hz) differ by at most 1 %, as the clocks of two devices may."""
    return abs(rate - other) <= TOLERANCE * other
