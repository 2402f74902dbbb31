"""Scores of answers by the time after the contact."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models._anytime_model import Answering, Answers
from firstcontact.models._metrics import cluster_intervals
from firstcontact.models._scores import AnytimeScores, Ends
from firstcontact.models._spec import Values
from firstcontact.models._touches import TIMES, Touches
from firstcontact.signal import samples_in

_STATISTICS: Mapping[str, Callable[[Values], Values]] = {
    "rmse": lambda s: np.sqrt(s[..., 1] / s[..., 0]),
    "coverage": lambda s: s[..., 2] / s[..., 0],
    "width": lambda s: s[..., 3] / s[..., 0],
}


def answers_by_time(
    model: Answering, touches: Touches, times: Sequence[int] = TIMES
) -> dict[int, Answers]:
    """Return predictions by time after the contact, ms, or at the second contact if earlier."""
    return {ms: model.answers(touches.until(samples_in(1e-3 * ms, touches.rate))) for ms in times}


def joined_answers(parts: Sequence[Answers]) -> Answers:
    """One after the other."""
    arrays = ([getattr(part, field.name) for part in parts] for field in fields(Answers))
    return Answers(*(np.concatenate(array) for array in arrays))


def anytime_scores(
    answers: Mapping[int, Answers], truth: Values, clusters: NDArray[Any], seed: int
) -> AnytimeScores:
    """Errors and intervals at each time, with bootstrap intervals over whole clusters.

    Parameters
    ----------
    answers
        By time, ms, to the same contacts at each.
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
        raise ValueError("there is no contact to score answers to")
    scores: dict[str, dict[str, float]] = {name: {} for name in _STATISTICS}
    intervals: dict[str, dict[str, Ends]] = {name: {} for name in _STATISTICS}
    strange = {}
    for ms, predictions in answers.items():
        is_inside = (predictions.low <= truth) & (truth <= predictions.high)
        columns = np.stack(
            [
                np.ones_like(truth),
                (predictions.values - truth) ** 2,
                is_inside,
                predictions.high - predictions.low,
            ],
            axis=1,
        )
        total = columns.sum(axis=0)
        ends = cluster_intervals(columns, _STATISTICS, clusters, seed)
        for name, statistic in _STATISTICS.items():
            scores[name][str(ms)] = float(statistic(total))
            if name in ends:
                intervals[name][str(ms)] = ends[name]
        strange[str(ms)] = float(predictions.strange.mean())
    return AnytimeScores(
        n=len(truth),
        **scores,
        strange=strange,
        intervals={name: ends for name, ends in intervals.items() if ends},
    )
