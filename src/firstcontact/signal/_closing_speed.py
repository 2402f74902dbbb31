"""Closing speed from reported positions of the hand."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from firstcontact.core import ArgumentError, ClosingSpeed
from firstcontact.core.pinch import FASTEST, SLOWEST

#: Positions are used from WINDOW to GUARD before the contact, s. The last positions are left out,
#: because a contact may be detected late and slows the finger down.
WINDOW, GUARD = 0.050, 0.003
#: Fewest positions for a line whose error can be estimated.
FEWEST = 3
#: Positions that differ by less than this count as equal, m.
SAME = 1e-9
#: Probability of a normal variable below 2 standard deviations.
BELOW_TWO = 0.97725
#: Cornish-Fisher expansion of Student's t quantile at that probability, in powers of 1 / freedom.
_CORNISH_FISHER = (169950 / 92160, 1098 / 384, 294 / 96, 10 / 4, 2.0)


def closing_speed(times: ArrayLike, positions: ArrayLike, at: float) -> ClosingSpeed | None:
    """Measure how fast the fingertip closes before a contact, from its positions.

    The speed is the slope of a line fitted to the positions from 50 to 3 ms before the contact. Its
    standard error comes from the residuals, or from the step of an encoder if that error is larger.
    The error is enlarged if there are few positions, so that the true speed lies within two
    standard errors in 95 % of contacts.

    Parameters
    ----------
    times
        Time of each position, s, in any order, shape (n,).
    positions
        Positions of the fingertip along its path, m, shape (n,), from any zero and in either
        direction.
    at
        Time of the contact, s, on the clock of ``times``.

    Returns
    -------
    ClosingSpeed or None
        Speed and its standard error. None with fewer than 3 positions from 50 to 3 ms before the
        contact, or if the finger does not move.

    Raises
    ------
    InputError
        ``times`` and ``positions`` differ in shape.

    Examples
    --------
    >>> import firstcontact as fc
    >>> times, positions = [0.96, 0.97, 0.98, 0.99], [0.0100, 0.0113, 0.0127, 0.0139]
    >>> measured = fc.closing_speed(times, positions, at=1.0)
    >>> round(measured.speed, 3), round(measured.error, 3)
    (0.131, 0.006)
    """
    t, x = np.asarray(times, np.float64) - at, np.asarray(positions, np.float64)
    if t.shape != x.shape:
        raise ArgumentError(
            f"the shape is {x.shape}, but times has the shape {t.shape}: give one position for "
            "each time",
            parameter="positions",
        )
    is_used = (t >= -WINDOW) & (t <= -GUARD) & np.isfinite(x)
    t, x = t[is_used], x[is_used]
    if len(t) < FEWEST:
        return None
    t, x = t - t.mean(), x - x.mean()
    squares = float(t @ t)
    if squares <= 0:
        return None
    slope = float(t @ x) / squares
    residuals = x - slope * t
    variance = max(float(residuals @ residuals) / (len(t) - 2), _step(x) ** 2 / 12)
    speed, error = abs(slope), _few(len(t) - 2) * math.sqrt(variance / squares)
    return ClosingSpeed(speed, error) if SLOWEST <= speed <= FASTEST and error <= FASTEST else None


def _few(freedom: int) -> float:
    """Return the factor that enlarges the speed's error if it comes from few positions."""
    # Not scipy.special: its import takes longer than the time from a contact to its estimate.
    if freedom == 1:
        return math.tan(math.pi * (BELOW_TWO - 0.5)) / 2
    if freedom == 2:
        return (BELOW_TWO - 0.5) / math.sqrt(2 * BELOW_TWO * (1 - BELOW_TWO))
    return float(np.polyval(_CORNISH_FISHER, 1 / freedom)) / 2


def _step(positions: NDArray[np.float64]) -> float:
    """Return the step of the encoder, m; 0 if no steps are detected."""
    travels = np.diff(np.sort(positions))
    moved = travels[travels > SAME]
    if not len(moved):
        return 0.0
    steps = moved / moved.min()
    is_seen = len(moved) < len(travels) or np.abs(steps - np.rint(steps)).max() < 1e-3
    return float(moved.min()) if is_seen else 0.0
