"""Conformal intervals by MAPIE, from predictions for held-out sessions.

The method is split conformal prediction with absolute residuals (Lei et al. 2018), applied
separately in each range of predictions (Mondrian; Vovk et al. 2005). Soft objects therefore get
bounds of their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._interval import SHORE_A, Interval
from firstcontact.models._spec import Values

#: Largest number of ranges of predictions, and smallest number of pinches in a range.
RANGES = 5
RANGE_PINCHES = 40
#: Smallest number of known sessions. With fewer, the difference between sessions is unknown.
SESSIONS = 3


def refusal(answers: Values, sessions: NDArray[np.str_], level: float) -> str:
    """Return the reason why these predictions give no interval; "" if they give one."""
    names = np.unique(sessions)
    if len(names) < SESSIONS or "" in names:
        named = len(names[names != ""])
        return f"{named} known sessions are too few for an interval: record {SESSIONS} or more"
    least = least_answers(level)
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
    """Return an interval that covers a share ``level`` of these truths.

    Parameters
    ----------
    answers
        Prediction for each pinch, by a model that did not learn from the pinch's session, shape
        (n,).
    truth
        True values, shape (n,).
    level
        Share of truths to cover.
    limits
        Ends of the scale of the predictions; None for a scale without ends.
    spreads
        Predicted standard deviation of each prediction (Papadopoulos et al. 2008), shape (n,). Half
        widths are then multiples of it. None if the models predict no standard deviation.

    Returns
    -------
    Interval
        Interval with up to five ranges of predictions, each with the same number of pinches.

    Raises
    ------
    ValueError
        There are fewer predictions than one range needs.
    """
    least = least_answers(level)
    if len(answers) < least:
        raise ValueError(f"{len(answers)} predictions are too few for a level of {level:g}")
    ranges = min(RANGES, len(answers) // least)
    edges = np.unique(np.quantile(answers, np.arange(1, ranges) / ranges))
    member = np.searchsorted(edges, answers, side="right")
    # Equal predictions crowd one range, which may leave too few for others: those are joined.
    while len(edges) and (few := np.bincount(member, minlength=len(edges) + 1)).min() < least:
        edges = np.delete(edges, max(0, int(few.argmin()) - 1))
        member = np.searchsorted(edges, answers, side="right")
    unit = np.ones(len(answers)) if spreads is None else spreads
    widths = [
        _half_width((answers / unit)[member == r], (truth / unit)[member == r], level)
        for r in range(len(edges) + 1)
    ]
    ends = tuple(float(e) for e in edges)
    return Interval(level, ends, tuple(widths), limits, scaled=spreads is not None)


def least_answers(level: float) -> int:
    """Return the smallest number of predictions for one range of an interval."""
    return max(RANGE_PINCHES, ceil(4.0 / (1.0 - level)))


def _half_width(answers: Values, truth: Values, level: float) -> float:
    from mapie.regression import SplitConformalRegressor

    conformal = SplitConformalRegressor(_identity(), confidence_level=level)
    conformal.conformalize(answers[:, None], truth)
    _, bounds = conformal.predict_interval(np.zeros((1, 1)))
    return float(bounds[0, 1, 0])


def _identity() -> Any:
    """Return a scikit-learn regressor whose predictions are its input."""
    from sklearn.base import BaseEstimator, RegressorMixin

    class Identity(RegressorMixin, BaseEstimator):  # type: ignore[misc]
        n_features_in_ = 1

        def fit(self, X: NDArray[Any], y: NDArray[Any]) -> Identity:
            return self

        def __sklearn_is_fitted__(self) -> bool:
            return True

        def predict(self, X: NDArray[Any]) -> Values:
            return np.asarray(X[:, 0], dtype=np.float64)

    return Identity()


def held_out_bounds(
    answers: Values,
    truth: Values,
    folds: NDArray[np.intp],
    level: float = 0.9,
    limits: tuple[float, float] | None = SHORE_A,
    spreads: Values | None = None,
) -> Iterator[tuple[Interval, NDArray[np.bool_]]]:
    """Yield the interval of each fold, made from the predictions of the other folds."""
    for fold in np.unique(folds):
        in_fold = folds == fold
        if (~in_fold).sum() >= least_answers(level):
            learned, other = ~in_fold, None if spreads is None else spreads[~in_fold]
            yield (
                conformal_interval(answers[learned], truth[learned], level, limits, other),
                in_fold,
            )


def coverage(
    pairs: Iterable[tuple[Interval, NDArray[np.bool_]]],
    answers: Values,
    truth: Values,
    spreads: Values | None = None,
) -> dict[str, float]:
    """Return the share of truths within their bounds, and the mean width of the intervals."""
    inside, widths = [], []
    for interval, rows in pairs:
        units = None if spreads is None else spreads[rows]
        low, high = interval.around_all(answers[rows], units)
        inside.append((low <= truth[rows]) & (truth[rows] <= high))
        widths.append(high - low)
    if not sum(map(len, inside)):
        return {}
    is_inside = np.concatenate(inside)
    return {
        "coverage": float(is_inside.mean()),
        "mean_width": float(np.concatenate(widths).mean()),
        "n": len(is_inside),
    }
