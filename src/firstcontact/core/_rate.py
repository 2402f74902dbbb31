"""When two sampling rates are one."""

from __future__ import annotations

#: Clocks of devices of one kind differ by less than this share.
TOLERANCE = 0.01


def is_same_rate(rate: float, other: float) -> bool:
    """Whether a rate is another, but for the error of a clock (one per cent); both in Hz."""
    return abs(rate - other) <= TOLERANCE * other
