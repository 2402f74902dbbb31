"""Closing speed of a hand before a contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from firstcontact.core._errors import InputError

#: Bounds on closing speeds, m/s, far beyond those of any hand.
SLOWEST, FASTEST = 1e-4, 10.0


@dataclass(frozen=True, slots=True)
class ClosingSpeed:
    """Closing speed just before a contact, as the hand measured it.

    Parameters
    ----------
    speed
        Speed, m/s.
    error
        Standard error of the speed, m/s; 0 for an exact speed.

    Raises
    ------
    InputError
        The speed is outside 0.1 mm/s to 10 m/s, or the error is outside 0 to 10 m/s.

    Examples
    --------
    >>> import firstcontact as fc
    >>> from dataclasses import replace
    >>> pinch = replace(fc.load("recordings")[0], closing_speed=fc.ClosingSpeed(0.13, 0.003))
    >>> pinch.closing_speed.speed
    0.13
    """

    speed: Annotated[float, Meta(ge=SLOWEST, le=FASTEST)]
    error: Annotated[float, Meta(ge=0, le=FASTEST)] = 0.0

    def __post_init__(self) -> None:
        for name, value, least in (("speed", self.speed, SLOWEST), ("error", self.error, 0.0)):
            if not least <= value <= FASTEST:  # true of NaN
                raise InputError(
                    f"the {name} of a closing is {value:g}: give a value in m/s, from {least:g} "
                    f"to {FASTEST:g}",
                    parameter=name,
                )
