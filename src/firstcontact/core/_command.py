"""What a grasp policy asks of a hand."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """One order to a hand; it holds until the next.

    Parameters
    ----------
    speed
        Of closing at each fingertip, m/s; negative opens, 0 stops.
    force
        Limit of what each fingertip may press with, N.

    Examples
    --------
    >>> gentle = Command(speed=0.02, force=1.5)
    >>> gentle.force
    1.5
    """

    speed: float
    force: float
