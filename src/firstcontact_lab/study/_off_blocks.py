"""What an estimator's answers about rigs come to, with intervals over rigs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.models import Ends, LabelledWindows, cluster_intervals
from firstcontact_lab.report.results.anytime import OffBlocks
from firstcontact_lab.study._rig_sets import Use

Values = NDArray[np.float64]
#: Pinches of one object whose answers are averaged.
TOGETHER = 3


@dataclass(frozen=True, slots=True, eq=False)
class Answered:
    """Answers to one question about one set; arrays share their first axis."""

    question: str
    place: int
    asked: LabelledWindows
    uses: NDArray[np.str_]
    values: Values


def off_blocks(answered: Sequence[Answered], options: Mapping[str, Any], seed: int) -> OffBlocks:
    """Scores of one entrant over all sets that it was asked about."""
    tally = _Tally(seed)
    objects = [_part(its, Use.OBJECTS) for its in answered]
    softest, hardest = _ends([its for its in objects if len(its.values)])
    for its in objects:
        tally.errors("objects", its.place, its.values - its.asked.y)
        tally.errors("three_pinches", its.place, _together(its, seed))
        for name, level in (("bias_softest", softest), ("bias_hardest", hardest)):
            which = its.asked.y == level
            tally.errors(name, its.place, its.values[which] - level)
    for its in answered:
        held = _part(its, Use.HELD)
        tally.errors("blocks", its.place, held.values - held.asked.y)
        tally.errors("accuracy", its.place, _nearest(held))
        other = _part(its, Use.OTHER_OBJECTS)
        tally.errors("other_hand", its.place, other.values - other.asked.y)
        left = _part(its, Use.BLOCKS)
        tally.errors("level_left_out", its.place, left.values - left.asked.y, its.question)
    return OffBlocks(
        sets=len({its.place for its in answered}),
        **tally.scores(),
        options=dict(options) or None,
        intervals=tally.intervals(),
    )


def _part(its: Answered, use: Use) -> Answered:
    which = np.flatnonzero(its.uses == use)
    return Answered(
        its.question, its.place, its.asked.take(which), its.uses[which], its.values[which]
    )


def _ends(parts: Sequence[Answered]) -> tuple[float, float]:
    shore_a = np.concatenate([its.asked.y for its in parts])
    return float(shore_a.min()), float(shore_a.max())


def _together(its: Answered, seed: int) -> Values:
    """Errors of means over pinches of one object, drawn in threes without replacement."""
    rng = np.random.default_rng([seed, its.place])
    errors = []
    for specimen in np.unique(its.asked.specimens):
        which = rng.permutation(np.flatnonzero(its.asked.specimens == specimen))
        whole = which[: len(which) // TOGETHER * TOGETHER].reshape(-1, TOGETHER)
        errors.append((its.values[whole] - its.asked.y[whole]).mean(axis=1))
    return np.concatenate(errors) if errors else np.empty(0)


def _nearest(its: Answered) -> Values:
    """1 where the answer lies nearest to its own block's level, shape (n,)."""
    levels = np.unique(its.asked.y)
    if not len(levels):
        return np.empty(0)
    nearest = levels[np.abs(its.values[:, None] - levels).argmin(axis=1)]
    out: Values = (nearest == its.asked.y).astype(np.float64)
    return out


def _rmse(groups: int) -> Callable[[Values], Values]:
    """Mean over groups of the root mean square, from their counts, sums and sums of squares."""

    def statistic(sums: Values) -> Values:
        by_group = sums.reshape(*sums.shape[:-1], groups, 3)
        with np.errstate(invalid="ignore"):  # a resample may lack a group
            out: Values = np.nanmean(np.sqrt(by_group[..., 2] / by_group[..., 0]), axis=-1)
        return out

    return statistic


def _mean(sums: Values) -> Values:
    out: Values = sums[..., 1] / sums[..., 0]
    return out


class _Tally:
    """Counts, sums and sums of squares of errors: by score, by group and by set."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._sums: dict[str, dict[str, dict[int, Values]]] = {}

    def errors(self, name: str, place: int, errors: Values, group: str = "") -> None:
        if len(errors):
            sums = np.array([len(errors), errors.sum(), (errors**2).sum()])
            of_group = self._sums.setdefault(name, {}).setdefault(group, {})
            of_group[place] = of_group.get(place, np.zeros(3)) + sums

    def _columns(self, name: str) -> tuple[Values, Callable[[Values], Values]]:
        """Sums of each set, shape (sets, 3 times groups), and what makes a score of them."""
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
        out: dict[str, Ends] = {}
        for name in self._sums:
            columns, statistic = self._columns(name)
            sets = np.arange(len(columns))
            out |= cluster_intervals(columns, {name: statistic}, sets, self._seed)
        return out
