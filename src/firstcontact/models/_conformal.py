"""Conformal intervals by MAPIE, from answers of models that had not seen the session.

Split conformal prediction with absolute residuals (Lei et al. 2018), by itself in
each range of answers (Mondrian; Vovk et al. 2005): soft objects get bounds of
their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._interval import SHORE_A, Interval
from firstcontact.models._spec import Values

#: Most ranges of answers, and fewest pinches in one.
RANGES = 5
RANGE_PINCHES = 40
#: With fewer known sessions nothing is known of how much sessions differ.
SESSIONS = 3


def refusal(answers: Values, sessions: NDArray[np.str_], level: float) -> str:
    """Return why these predictions give no interval, or ""."""
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
    """Widths with which ``level`` of these truths lie around their answers.

    Parameters
    ----------
    answers
        Of models that did not learn from the session asked about, shape (n,).
    truth
        Shape (n,).
    level
        Share that is to be held.
    limits
        Of the scale; None where it has no ends.
    spreads
        What the models themselves said of each answer (Papadopoulos et al. 2008), shape
        (n,): half widths are in these then; None where they said nothing.

    Returns
    -------
    Interval
        Up to five ranges of answers with as many pinches each.

    Raises
    ------
    ValueError
        Fewer answers than one range needs.
    """
    least = least_answers(level)
    if len(answers) < least:
        raise ValueError(f"{len(answers)} answers are too few for a level of {level:g}")
    ranges = min(RANGES, len(answers) // least)
    edges = np.unique(np.quantile(answers, np.arange(1, ranges) / ranges))
    member = np.searchsorted(edges, answers, side="right")
    # Answers that are all alike fill one range and leave others thin: those are joined.
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
    """Fewest answers that one range of an interval is made of."""
    return max(RANGE_PINCHES, ceil(4.0 / (1.0 - level)))


def _half_width(answers: Values, truth: Values, level: float) -> float:
    from mapie.regression import SplitConformalRegressor

    conformal = SplitConformalRegressor(_identity(), confidence_level=level)
    conformal.conformalize(answers[:, None], truth)
    _, bounds = conformal.predict_interval(np.zeros((1, 1)))
    return float(bounds[0, 1, 0])


def _identity() -> Any:
    """Return a regressor in scikit-learn's form whose input is the answer itself."""
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
    """Each fold with an interval from the other folds.

    Parameters
    ----------
    answers, truth
        As for :func:`conformal_interval`.
    folds
        Number of each answer's fold; a session lies in one. Shape (n,).
    level, limits, spreads
        As for :func:`conformal_interval`.

    Yields
    ------
    interval, asked
        The interval, and where the answers of the fold are, shape (n,). A fold
        without which too few answers are left is not asked.
    """
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
    """Return the share of truths within their bounds, and the mean width.

    Returns
    -------
    dict
        ``coverage`` (share), ``mean_width`` (unit of the answer) and ``n``;
        empty when nothing was asked.
    """
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
