"""Scores of answers by the time after the contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._metrics import cluster_intervals
from firstcontact.models._predictions import ContactPredictor, Predictions
from firstcontact.models._scores import AnytimeScores, Ends
from firstcontact.models._spec import Values
from firstcontact.models._touches import TIMES, Touches
from firstcontact.signal import samples_in

_STATISTICS: Mapping[str, Callable[[Values], Values]] = {
    "rmse": lambda s: np.sqrt(s[..., 1] / s[..., 0]),
    "coverage": lambda s: s[..., 2] / s[..., 0],
    "width": lambda s: s[..., 3] / s[..., 0],
}


def predictions_by_time(
    model: ContactPredictor, touches: Touches, times: Sequence[int] = TIMES
) -> dict[int, Predictions]:
    """Return predictions by time after the contact, ms, or at the second contact if earlier."""
    return {ms: model.predict(touches.until(samples_in(1e-3 * ms, touches.rate))) for ms in times}


def anytime_scores(
    predictions: Mapping[int, Predictions], truth: Values, clusters: NDArray[Any], seed: int
) -> AnytimeScores:
    """Errors and intervals at each time, with bootstrap intervals over whole clusters.

    Parameters
    ----------
    predictions
        By time, ms, of the same contacts at each.
    truth
        Shore A, shape (n,).
    clusters
        What is resampled as a whole, shape (n,).
    seed
        Of the resampling.

    Raises
    ------
    ValueError
        No contact.
    """
    if not len(truth):
        raise ValueError("there is no contact to score")
    scores: dict[str, dict[str, float]] = {name: {} for name in _STATISTICS}
    intervals: dict[str, dict[str, Ends]] = {name: {} for name in _STATISTICS}
    out_of_range = {}
    for ms, at_time in predictions.items():
        is_inside = (at_time.low <= truth) & (truth <= at_time.high)
        columns = np.stack(
            [
                np.ones_like(truth),
                (at_time.value - truth) ** 2,
                is_inside,
                at_time.high - at_time.low,
            ],
            axis=1,
        )
        total = columns.sum(axis=0)
        ends = cluster_intervals(columns, _STATISTICS, clusters, seed)
        for name, statistic in _STATISTICS.items():
            scores[name][str(ms)] = float(statistic(total))
            if name in ends:
                intervals[name][str(ms)] = ends[name]
        out_of_range[str(ms)] = float(at_time.out_of_range.mean())
    return AnytimeScores(
        n=len(truth),
        **scores,
        strange=out_of_range,
        intervals={name: ends for name, ends in intervals.items() if ends},
    )
