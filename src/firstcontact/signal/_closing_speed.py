"""Closing speed of the fingertip, from positions that the hand reports."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from firstcontact.core import ArgumentError, ClosingSpeed
from firstcontact.core.pinch import FASTEST, SLOWEST

#: Positions are used from WINDOW to GUARD before the contact, s. The last positions are left out,
#: because a contact may be detected late and slows the finger down.
WINDOW, GUARD = 0.050, 0.003
#: Positions of a slow encoder, of which too few are in WINDOW, are used from SLOW on, s.
SLOW = 0.120
#: Reported speeds count from RECENT on. Their factor comes from the motion since HISTORY, s.
RECENT, HISTORY = 0.030, 0.500
#: Relative error up to which a reported speed is used even if that of the positions is smaller: a
#: line through positions lags behind a finger that speeds up.
GOOD = 0.03
#: Share of sums of squares of residuals, in variances, below degrees of freedom + this many roots
#: of twice their number, if positions have no other error than the encoder's step.
CONSISTENT = 3.0
#: Fewest positions for a line whose error can be estimated.
FEWEST = 3
#: Positions that differ by less than this count as equal, m.
SAME = 1e-9
#: Probability of a normal variable below 2 standard deviations.
BELOW_TWO = 0.97725
#: Cornish-Fisher expansion of Student's t quantile at that probability, in powers of 1 / freedom.
_CORNISH_FISHER = (169950 / 92160, 1098 / 384, 294 / 96, 10 / 4, 2.0)


def closing_speed(
    times: ArrayLike,
    positions: ArrayLike,
    at: float,
    *,
    resolution: float | None = None,
    speeds: ArrayLike | None = None,
) -> ClosingSpeed | None:
    """Measure how fast the fingertip closes before a contact, from its positions.

    The speed is the slope of a line fitted to the positions from 50 to 3 ms before the contact, or
    from 120 ms if there are fewer than 3. Its standard error comes from the residuals, or from the
    step of an encoder if that error is larger. The error is enlarged if there are few positions, so
    that the true speed lies within two standard errors in 95 % of contacts whose speed is constant.
    With ``resolution``, a speed that changes may be off by more: few positions cannot show it.

    Parameters
    ----------
    times
        Time of each position, s, in any order, shape (n,).
    positions
        Positions of the fingertip along its path, m, shape (n,), from any zero and in either
        direction.
    at
        Time of the contact, s, on the clock of ``times``.
    resolution
        Step of the encoder, m, if its positions have no other error. Then few positions suffice.
        None if unknown.
    speeds
        Speeds that the hand reports at these times, shape (n,), in any unit and NaN if absent. The
        positions calibrate them. They are used if their error is at most 3 % or the smaller one.

    Returns
    -------
    ClosingSpeed or None
        Speed and its standard error. None with fewer than 3 positions from 120 to 3 ms before the
        contact, or if the finger does not move.

    Raises
    ------
    InputError
        ``times`` differ in shape from ``positions`` or ``speeds``, or the resolution is negative.

    Examples
    --------
    >>> import firstcontact as fc
    >>> times, positions = [0.96, 0.97, 0.98, 0.99], [0.0100, 0.0113, 0.0127, 0.0139]
    >>> measured = fc.closing_speed(times, positions, at=1.0)
    >>> round(measured.speed, 3), round(measured.error, 3)
    (0.131, 0.006)
    """
    t, x = np.asarray(times, np.float64) - at, np.asarray(positions, np.float64)
    v = np.full_like(t, np.nan) if speeds is None else np.asarray(speeds, np.float64)
    for name, values in (("positions", x), ("speeds", v)):
        if t.shape != values.shape:
            raise ArgumentError(
                f"the shape is {values.shape}, but times has the shape {t.shape}: give one value "
                "for each time",
                parameter=name,
            )
    if resolution is not None and not 0 <= resolution < math.inf:
        message = f"{resolution} is not the step of an encoder: give the step in m, 0 or more"
        raise ArgumentError(message, parameter="resolution")
    is_near = (t <= -GUARD) & np.isfinite(x)
    order = np.argsort(t[is_near], kind="stable")
    t, x, v = (values[is_near][order] for values in (t, x, v))
    start = next((s for s in (WINDOW, SLOW) if np.sum(t >= -s) >= FEWEST), SLOW)
    line = _fit_slope(t[t >= -start], x[t >= -start], resolution)
    reported = _speed_from_reports(t, x, v, resolution)
    if reported and line and reported[1] > max(line[1], GOOD * reported[0]):
        reported = None
    measured = reported or line
    if measured is None or not (SLOWEST <= measured[0] <= FASTEST >= measured[1]):
        return None
    return ClosingSpeed(*measured)


def _fit_slope(
    along: NDArray[np.float64], x: NDArray[np.float64], resolution: float | None
) -> tuple[float, float] | None:
    """Fit a line to ``x`` over ``along``. Return its absolute slope and the standard error.

    ``resolution`` is the encoder's step, in the unit of ``x``; None if unknown. Return None for
    fewer than 3 points, or if all have the same ``along``.
    """
    if len(along) < FEWEST:
        return None
    t, x = along - along.mean(), x - x.mean()
    squares = float(t @ t)
    if squares <= 0:
        return None
    slope, freedom = float(t @ x) / squares, len(t) - 2
    residuals = x - slope * t
    total, step = float(residuals @ residuals), _visible_step(x) ** 2 / 12
    if resolution is not None:
        step = max(step, resolution**2 / 12)
        if total <= step * (freedom + CONSISTENT * math.sqrt(2 * freedom)):
            return abs(slope), math.sqrt(step / squares)
    return abs(slope), _small_sample_factor(freedom) * math.sqrt(
        max(total / freedom, step) / squares
    )


def _speed_from_reports(
    t: NDArray[np.float64],
    x: NDArray[np.float64],
    speeds: NDArray[np.float64],
    resolution: float | None,
) -> tuple[float, float] | None:
    """Return the closing speed and its standard error, m/s, from speeds that the hand reports.

    ``t`` are times relative to the contact, s (negative before it), ``x`` positions, m, and
    ``speeds`` reported speeds in any unit. Return None if fewer than 3 are recent enough.
    """
    is_used = np.isfinite(speeds) & (t >= -HISTORY)
    t, x, v = t[is_used], x[is_used], speeds[is_used]
    # The path in the unit of the speeds, along which the positions are a line.
    path = np.concatenate([[0.0], np.cumsum(np.diff(t) * (v[1:] + v[:-1]) / 2)])
    factor = _fit_slope(path, x, resolution)
    newest, near = v[t >= -RECENT], t[t >= -RECENT]
    if factor is None or len(newest) < FEWEST or np.ptp(near) <= 0:
        return None
    # A line to the contact, because a finger may speed up or slow down.
    middle, freedom = float(near.mean()), len(near) - 2
    squares = float((near - middle) @ (near - middle))
    slope = float((near - middle) @ newest) / squares
    residuals = newest - newest.mean() - slope * (near - middle)
    variance = max(float(residuals @ residuals) / freedom, _visible_step(newest) ** 2 / 12)
    spread = _small_sample_factor(freedom) * math.sqrt(
        variance * (1 / len(near) + middle**2 / squares)
    )
    speed = abs(float(newest.mean()) - slope * middle)
    return factor[0] * speed, math.hypot(factor[1] * speed, factor[0] * spread)


def _small_sample_factor(freedom: int) -> float:
    """Return the factor by which to enlarge a standard error from few samples.

    With it, the true value lies within two standard errors in 95 % of cases. ``freedom`` is the
    number of degrees of freedom.
    """
    # Not scipy.special: its import takes longer than the time from a contact to its estimate.
    if freedom == 1:
        return math.tan(math.pi * (BELOW_TWO - 0.5)) / 2
    if freedom == 2:
        return (BELOW_TWO - 0.5) / math.sqrt(2 * BELOW_TWO * (1 - BELOW_TWO))
    return float(np.polyval(_CORNISH_FISHER, 1 / freedom)) / 2


def _visible_step(positions: NDArray[np.float64]) -> float:
    """Return the step of the encoder, in the unit of ``positions``; 0 if they show none."""
    travels = np.diff(np.sort(positions))
    moved = travels[travels > SAME]
    if not len(moved):
        return 0.0
    steps = moved / moved.min()
    is_seen = len(moved) < len(travels) or np.abs(steps - np.rint(steps)).max() < 1e-3
    return float(moved.min()) if is_seen else 0.0
