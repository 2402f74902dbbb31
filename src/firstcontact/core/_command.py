"""Commands that a grasp policy sends to a hand."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Command:
    """Command to a hand, valid until the next command.

    Parameters
    ----------
    speed
        Closing speed of each fingertip, m/s. Negative values open the hand, 0 stops it.
    force
        Largest force of each fingertip, N.

    Examples
    --------
    >>> gentle = Command(speed=0.02, force=1.5)
    >>> gentle.force
    1.5
    """

    speed: float
    force: float
