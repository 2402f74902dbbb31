"""Conformal intervals around predictions, from predictions for held-out sessions.

The method is split conformal prediction with absolute residuals (Lei et al. 2018), applied
separately in each range of predictions (Mondrian; Vovk et al. 2005). Soft objects therefore get
bounds of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import quantity
from firstcontact.models.values import Values

#: Ends of the Shore A scale.
SHORE_A = (quantity.SHORE_A.least, quantity.SHORE_A.most)
#: Largest number in an interval, so that predictions with their bounds stay finite.
LARGEST_BOUND = 1e9
#: Largest number of ranges of predictions, and smallest number of pinches in a range.
RANGES = 5
RANGE_PINCHES = 40
#: Smallest number of known sessions. With fewer, the difference between sessions is unknown.
SESSIONS = 3


@dataclass(frozen=True, slots=True)
class Interval:
    """Rule for the interval around a prediction. The width depends on the predicted value.

    Parameters
    ----------
    level
        Nominal coverage, between 0 and 1: share of intervals that should contain the true value.
        It holds only for contacts that are like the training data.
    edges
        Predicted values at which the width changes, ascending; one fewer than ``half_widths``.
    half_widths
        Half widths of the interval, one for each range between edges, in the target's unit. The
        first holds below the first edge, the last above the last edge.
    limits
        Ends of the target's scale, to which the bounds are clipped; None for a scale without ends.
    scaled
        True if half widths are multiples of the predicted standard deviation.

    Examples
    --------
    >>> interval = Interval(0.9, edges=(30.0,), half_widths=(2.0, 5.0))
    >>> interval.around(20.0), interval.around(98.0)
    ((18.0, 22.0), (93.0, 100.0))
    """

    level: float
    edges: tuple[float, ...]
    half_widths: tuple[float, ...]
    limits: tuple[float, float] | None = SHORE_A
    scaled: bool = False

    def __post_init__(self) -> None:
        numbers = (self.level, *self.edges, *self.half_widths, *(self.limits or ()))
        if (
            not all(abs(n) <= LARGEST_BOUND for n in numbers)
            or not 0.0 < self.level < 1.0
            or len(self.half_widths) != len(self.edges) + 1
            or min(self.half_widths) < 0.0
            or list(self.edges) != sorted(self.edges)
            or (self.limits is not None and self.limits[0] >= self.limits[1])
        ):
            raise ValueError(
                "level, edges, half_widths or limits do not fit together: give one width more"
            )

    def around(self, value: float, spread: float = 1.0) -> tuple[float, float]:
        """Return lower and upper bound of the interval around one prediction.

        ``spread`` is the predicted standard deviation. It counts only if the rule is ``scaled``.
        """
        low, high = self.around_all(np.array([value]), np.array([spread]))
        return float(low[0]), float(high[0])

    def around_all(self, values: Values, spreads: Values | None = None) -> tuple[Values, Values]:
        """Return the lower and the upper bounds of the intervals around predictions, (n,) each.

        ``spreads`` are the predicted standard deviations, shape (n,). They count only if the rule
        is ``scaled``.
        """
        half = np.array(self.half_widths)[np.searchsorted(self.edges, values, side="right")]
        if self.scaled and spreads is not None:
            half = half * spreads
        low, high = values - half, values + half
        if self.limits is None:
            return low, high
        return np.clip(low, *self.limits), np.clip(high, *self.limits)


def least_predictions(level: float) -> int:
    """Return the smallest number of held-out predictions that an interval can be made from."""
    return max(RANGE_PINCHES, ceil(4.0 / (1.0 - level)))


def missing_interval_reason(answers: Values, sessions: NDArray[np.str_], level: float) -> str:
    """Return why held-out predictions are too few for an interval; "" if they are enough.

    ``sessions`` holds the session of each prediction, shape (n,).
    """
    names = np.unique(sessions)
    if len(names) < SESSIONS or "" in names:
        named = len(names[names != ""])
        return f"{named} known sessions are too few for an interval: record {SESSIONS} or more"
    least = least_predictions(level)
    if len(answers) < least:
        return f"{len(answers)} pinches are too few for an interval: record {least} or more"
    return ""


def conformal_interval(
    answers: Values,
    truth: Values,
    level: float = 0.9,
    limits: tuple[float, float] | None = SHORE_A,
    spreads: Values | None = None,
) -> Interval:
    """Return a rule for intervals that contain the share ``level`` of the true values.

    ``answers`` are held-out predictions and ``truth`` the true values, shape (n,). ``limits`` are
    the ends of the scale. ``spreads`` are predicted standard deviations; with them, half widths are
    multiples of these. Raise ValueError if there are fewer than :func:`least_predictions`.
    """
    least = least_predictions(level)
    if len(answers) < least:
        raise ValueError(
            f"{len(answers)} predictions are too few for intervals of the level {level:g}: give "
            f"{least} or more"
        )
    ranges = min(RANGES, len(answers) // least)
    edges = np.unique(np.quantile(answers, np.arange(1, ranges) / ranges))
    member = np.searchsorted(edges, answers, side="right")
    # Equal predictions crowd one range, which may leave too few for others: those are joined.
    while len(edges) and (few := np.bincount(member, minlength=len(edges) + 1)).min() < least:
        edges = np.delete(edges, max(0, int(few.argmin()) - 1))
        member = np.searchsorted(edges, answers, side="right")
    unit = np.ones(len(answers)) if spreads is None else spreads
    residuals = np.abs(truth / unit - answers / unit)
    widths = tuple(_half_width(residuals[member == r], level) for r in range(len(edges) + 1))
    ends = tuple(float(e) for e in edges)
    return Interval(level, ends, widths, limits, scaled=spreads is not None)


def _half_width(residuals: Values, level: float) -> float:
    """Return half the width of a conformal interval with the coverage ``level``.

    It is number ⌈(n + 1) ``level``⌉ of the n residuals in ascending order.
    """
    return float(np.sort(residuals)[ceil((len(residuals) + 1) * level) - 1])


def held_out_coverage(
    answers: Values,
    truth: Values,
    folds: NDArray[np.intp],
    level: float = 0.9,
    limits: tuple[float, float] | None = SHORE_A,
    spreads: Values | None = None,
) -> dict[str, float]:
    """Score intervals for each fold that are made from the predictions of the other folds.

    ``folds`` holds the fold of each prediction, shape (n,). Return "coverage" (0 to 1),
    "mean_width" in the target's unit and "n", the number of scored predictions; {} if there are too
    few.
    """
    inside, widths = [], []
    for fold in np.unique(folds):
        asked, other = folds == fold, folds != fold
        if other.sum() < least_predictions(level):
            continue
        units = (None, None) if spreads is None else (spreads[other], spreads[asked])
        interval = conformal_interval(answers[other], truth[other], level, limits, units[0])
        low, high = interval.around_all(answers[asked], units[1])
        inside.append((low <= truth[asked]) & (truth[asked] <= high))
        widths.append(high - low)
    if not inside:
        return {}
    is_inside = np.concatenate(inside)
    return {
        "coverage": float(is_inside.mean()),
        "mean_width": float(np.concatenate(widths).mean()),
        "n": len(is_inside),
    }
