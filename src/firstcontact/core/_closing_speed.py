"""Closing speed of a hand before a contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

#: Fastest closing of a hand, m/s: far beyond any.
FASTEST = 10.0


@dataclass(frozen=True, slots=True)
class ClosingSpeed:
    """Closing speed just before a contact, as the hand measured it.

    Parameters
    ----------
    speed
        Speed, m/s.
    error
        Standard error of it, m/s; 0 for an exact one.

    Examples
    --------
    >>> import firstcontact as fc
    >>> from dataclasses import replace
    >>> pinch = replace(fc.load("recordings")[0], closing_speed=fc.ClosingSpeed(0.13, 0.003))
    >>> pinch.closing_speed.speed
    0.13
    """

    speed: Annotated[float, Meta(gt=0, le=FASTEST)]
    error: Annotated[float, Meta(ge=0, le=FASTEST)] = 0.0
