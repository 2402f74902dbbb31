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
    """What a model says so long (ms) after each contact, or when the second finger touched."""
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
    found: dict[str, dict[str, float]] = {name: {} for name in _STATISTICS}
    intervals: dict[str, dict[str, Ends]] = {name: {} for name in _STATISTICS}
    strange = {}
    for ms, its in answers.items():
        held = (its.low <= truth) & (truth <= its.high)
        columns = np.stack(
            [np.ones_like(truth), (its.values - truth) ** 2, held, its.high - its.low], axis=1
        )
        total = columns.sum(axis=0)
        ends = cluster_intervals(columns, _STATISTICS, clusters, seed)
        for name, statistic in _STATISTICS.items():
            found[name][str(ms)] = float(statistic(total))
            if name in ends:
                intervals[name][str(ms)] = ends[name]
        strange[str(ms)] = float(its.strange.mean())
    return AnytimeScores(
        n=len(truth),
        **found,
        strange=strange,
        intervals={name: its for name, its in intervals.items() if its},
    )
