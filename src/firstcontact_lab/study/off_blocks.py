"""Scores of estimators beyond their training blocks, with bootstrap intervals over rigs.

The study part ``generalise`` shows them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.models.labelled_data import LabelledWindows
from firstcontact.models.scores import Ends, cluster_intervals
from firstcontact_lab.study.rig_sets import PinchUse

Values = NDArray[np.float64]
TOGETHER = 3


class OffBlocks(Record, frozen=True, kw_only=True):
    """Scores of an estimator beyond its training blocks. RMSE and bias are in Shore A."""

    sets: int
    objects: float
    three_pinches: float
    bias_softest: float
    bias_hardest: float
    bias: float | None = None
    bias_other_hand: float | None = None
    blocks: float | None = None
    accuracy: float | None = None
    other_hand: float | None = None
    level_left_out: float | None = None
    options: dict[str, Any] | None = None
    intervals: dict[str, Ends]


@dataclass(frozen=True, slots=True, eq=False)
class RigSetPredictions:
    """Predictions of one estimator, Shore A, for pinches of one rig set (two simulated hands).

    ``place`` is the index of the rig set.
    """

    question: str
    place: int
    queries: LabelledWindows
    uses: NDArray[np.str_]
    values: Values


def score_off_blocks(
    answered: Sequence[RigSetPredictions], options: Mapping[str, Any], seed: int
) -> OffBlocks:
    tally = _ErrorSums(seed)
    objects = [_part(batch, PinchUse.OBJECTS) for batch in answered]
    softest, hardest = _ends([batch for batch in objects if len(batch.values)])
    for batch in objects:
        for name in ("objects", "bias"):
            tally.errors(name, batch.place, batch.values - batch.queries.y)
        tally.errors("three_pinches", batch.place, _errors_of_three(batch, seed))
        for name, level in (("bias_softest", softest), ("bias_hardest", hardest)):
            indices = batch.queries.y == level
            tally.errors(name, batch.place, batch.values[indices] - level)
    for batch in answered:
        held_out = _part(batch, PinchUse.HELD)
        tally.errors("blocks", batch.place, held_out.values - held_out.queries.y)
        tally.errors("accuracy", batch.place, _block_hits(held_out))
        other = _part(batch, PinchUse.OTHER_OBJECTS)
        for name in ("other_hand", "bias_other_hand"):
            tally.errors(name, batch.place, other.values - other.queries.y)
        left = _part(batch, PinchUse.BLOCKS)
        tally.errors("level_left_out", batch.place, left.values - left.queries.y, batch.question)
    return OffBlocks(
        sets=len({batch.place for batch in answered}),
        **tally.scores(),
        options=dict(options) or None,
        intervals=tally.intervals(),
    )


def _part(answered: RigSetPredictions, use: PinchUse) -> RigSetPredictions:
    indices = np.flatnonzero(answered.uses == use)
    return RigSetPredictions(
        answered.question,
        answered.place,
        answered.queries.take(indices),
        answered.uses[indices],
        answered.values[indices],
    )


def _ends(parts: Sequence[RigSetPredictions]) -> tuple[float, float]:
    shore_a = np.concatenate([answered.queries.y for answered in parts])
    return float(shore_a.min()), float(shore_a.max())


def _errors_of_three(answered: RigSetPredictions, seed: int) -> Values:
    """Return errors of the mean prediction of three pinches of the same object, Shore A."""
    rng = np.random.default_rng([seed, answered.place])
    errors = []
    for specimen in np.unique(answered.queries.specimens):
        indices = rng.permutation(np.flatnonzero(answered.queries.specimens == specimen))
        triples = indices[: len(indices) // TOGETHER * TOGETHER].reshape(-1, TOGETHER)
        errors.append((answered.values[triples] - answered.queries.y[triples]).mean(axis=1))
    return np.concatenate(errors) if errors else np.empty(0)


def _block_hits(answered: RigSetPredictions) -> Values:
    """Return 1 where the block nearest to the prediction is the true one, otherwise 0.

    "Nearest" compares Shore A values.
    """
    levels = np.unique(answered.queries.y)
    if not len(levels):
        return np.empty(0)
    nearest = levels[np.abs(answered.values[:, None] - levels).argmin(axis=1)]
    out: Values = (nearest == answered.queries.y).astype(np.float64)
    return out


def _rmse(groups: int) -> Callable[[Values], Values]:
    """Return a function that turns sums of errors into an RMSE, averaged over ``groups`` groups."""

    def statistic(sums: Values) -> Values:
        by_group = sums.reshape(*sums.shape[:-1], groups, 3)
        with np.errstate(invalid="ignore"):  # a resample may lack a group
            out: Values = np.nanmean(np.sqrt(by_group[..., 2] / by_group[..., 0]), axis=-1)
        return out

    return statistic


def _mean(sums: Values) -> Values:
    out: Values = sums[..., 1] / sums[..., 0]
    return out


def _of_columns(statistic: Callable[[Values], Values], part: slice) -> Callable[[Values], Values]:
    return lambda sums: statistic(sums[..., part])


class _ErrorSums:
    """Sums of errors, from which scores and their bootstrap intervals are computed.

    Each entry holds the number, the sum and the sum of squares of the errors of one score, in one
    group, on one rig set.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._sums: dict[str, dict[str, dict[int, Values]]] = {}

    def errors(self, name: str, place: int, errors: Values, group: str = "") -> None:
        if len(errors):
            sums = np.array([len(errors), errors.sum(), (errors**2).sum()])
            of_group = self._sums.setdefault(name, {}).setdefault(group, {})
            of_group[place] = of_group.get(place, np.zeros(3)) + sums

    def _columns(self, name: str) -> tuple[Values, Callable[[Values], Values]]:
        """Return (sums, function) for the score ``name``. The function turns total sums into it.

        The sums have the shape (rig sets, 3 · groups).
        """
        groups = self._sums[name].values()
        places = sorted({place for of_group in groups for place in of_group})
        columns = np.array(
            [np.concatenate([g.get(place, np.zeros(3)) for g in groups]) for place in places]
        )
        means = name.startswith("bias") or name == "accuracy"
        return columns, _mean if means else _rmse(len(groups))

    def scores(self) -> dict[str, float]:
        out = {}
        for name in self._sums:
            columns, statistic = self._columns(name)
            out[name] = float(statistic(columns.sum(axis=0)))
        return out

    def intervals(self) -> dict[str, Ends]:
        scores = {name: self._columns(name) for name in self._sums}
        out: dict[str, Ends] = {}
        # Scores over equally many sets share the resamples.
        for sets in {len(columns) for columns, _ in scores.values()}:
            alike = [(name, *score) for name, score in scores.items() if len(score[0]) == sets]
            stops = accumulate(columns.shape[1] for _, columns, _ in alike)
            statistics = {
                name: _of_columns(statistic, slice(stop - columns.shape[1], stop))
                for (name, columns, statistic), stop in zip(alike, stops, strict=True)
            }
            joined = np.hstack([columns for _, columns, _ in alike])
            out |= cluster_intervals(joined, statistics, np.arange(sets), self._seed)
        return {name: out[name] for name in scores if name in out}
