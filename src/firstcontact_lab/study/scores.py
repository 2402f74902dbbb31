"""Splits of a study, and scores by time after the contact, by object, and of ranks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.models import Predictions, Touches
from firstcontact.models.predictions import TouchPredictor
from firstcontact.models.scores import Ends, SpecimenErrors, cluster_intervals, share_interval
from firstcontact.models.splits import Group, Split
from firstcontact.models.values import Values
from firstcontact.signal import samples_in

RANDOM_FOLDS = 5
#: Half width of a normal's 90 % interval, in standard deviations.
NORMAL = 1.645
#: Share of the pinches that the paper's random split keeps for testing.
RANDOM_TEST = 0.1


def random_90_10(classes: NDArray[Any], seed: int) -> list[Split]:
    """Return the paper's split: a random 90 % of the pinches of each class train the model."""
    from sklearn.model_selection import StratifiedShuffleSplit

    splitter = StratifiedShuffleSplit(1, test_size=RANDOM_TEST, random_state=seed)
    shares = frozenset({Group.SESSION, Group.SPECIMEN})
    # scikit-learn refuses to stratify by fractional values.
    strata = np.unique(classes, return_inverse=True)[1]
    return [
        Split("random_90_10", train, test, shares)
        for train, test in splitter.split(classes[:, None], strata)
    ]


def random_folds(classes: NDArray[Any], seed: int, folds: int = RANDOM_FOLDS) -> list[Split]:
    """Return random stratified folds. Scores on them are optimistic, so only compare them."""
    from sklearn.model_selection import StratifiedKFold

    _, strata, counts = np.unique(classes, return_inverse=True, return_counts=True)
    fewest = int(counts.min(initial=len(classes)))
    if fewest < 2:
        raise ValueError(
            f"random folds need at least two pinches of each class, but one class has {fewest}: "
            "add pinches"
        )
    splitter = StratifiedKFold(min(folds, fewest), shuffle=True, random_state=seed)
    shares = frozenset({Group.SESSION, Group.SPECIMEN})
    return [
        Split(f"random fold {i}", train, test, shares)
        for i, (train, test) in enumerate(splitter.split(classes[:, None], strata))
    ]


def unseen_objects(test: NDArray[np.bool_], shares: Sequence[Group] = ()) -> Split:
    """Return the split that trains on pinches of role ``train`` and tests on role ``test``.

    ``test`` is a mask of the pinches of role ``test``. ``shares`` names what both sides have in
    common.
    """
    learn, ask = np.flatnonzero(~test), np.flatnonzero(test)
    return Split("unseen objects", learn, ask, frozenset(shares))


def learns_one_value(splits: Sequence[Split], values: NDArray[Any]) -> bool:
    """Return True if the training side of any split has fewer than two distinct values."""
    return any(len(np.unique(values[split.train])) < 2 for split in splits)


def never_learned(splits: Sequence[Split], classes: NDArray[Any]) -> NDArray[Any]:
    """Return the classes that some split tests without training on them."""
    lacking = [np.setdiff1d(classes[split.test], classes[split.train]) for split in splits]
    return np.unique(np.concatenate(lacking)) if lacking else classes[:0]


class AnytimeScores(Record, frozen=True, kw_only=True):
    """Scores on ``n`` pinches, by time after the contact in ms."""

    n: int
    rmse: dict[str, float]
    coverage: dict[str, float]
    width: dict[str, float]
    out_of_range: dict[str, float] = msgspec.field(name="strange")
    intervals: dict[str, dict[str, Ends]]


class MeanErrors(Record, frozen=True, kw_only=True):
    """Errors, Shore A, of the mean prediction of each of ``n`` specimens or objects."""

    rmse: float
    mae: float
    mse: float
    bias: float
    n: int


class RankCorrelation(Record, frozen=True, kw_only=True):
    """Spearman's rho over ``n`` groups, and its two-sided p-value."""

    rho: float | None = None
    n: int
    p: float | None = None
    exact: bool | None = None


_STATISTICS: Mapping[str, Callable[[Values], Values]] = {
    "rmse": lambda s: np.sqrt(s[..., 1] / s[..., 0]),
    "coverage": lambda s: s[..., 2] / s[..., 0],
    "width": lambda s: s[..., 3] / s[..., 0],
}


def predictions_by_time(
    model: TouchPredictor, touches: Touches, times: Sequence[int] = Touches.SCORED_MS
) -> dict[int, Predictions]:
    """Return the predictions of a model, as a dictionary from the time after the contact in ms.

    Samples from the second contact on are not used.
    """
    return {
        ms: model.predict_touches(touches.until(samples_in(1e-3 * ms, touches.rate)))
        for ms in times
    }


def anytime_scores(
    predictions: Mapping[int, Predictions], truth: Values, clusters: NDArray[Any], seed: int
) -> AnytimeScores:
    if not len(truth):
        raise ValueError("there is no contact to score: label contacts")
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
        if inside := share_interval(is_inside, clusters):
            ends["coverage"] = inside
        for name, statistic in _STATISTICS.items():
            scores[name][str(ms)] = float(statistic(total))
            if name in ends:
                intervals[name][str(ms)] = ends[name]
        out_of_range[str(ms)] = float(at_time.out_of_range.mean())
    return AnytimeScores(
        n=len(truth),
        **scores,
        out_of_range=out_of_range,
        intervals={name: ends for name, ends in intervals.items() if ends},
    )


def join_by_time(parts: Sequence[Mapping[int, Predictions]]) -> dict[int, Predictions]:
    """Return the predictions for several groups of contacts, concatenated at each time (ms)."""
    joined = {}
    for ms in parts[0]:
        columns = zip(*(part[ms].columns for part in parts), strict=True)
        value, spread, low, high, out_of_range, elapsed = map(np.concatenate, columns)
        joined[ms] = Predictions(value, spread, low, high, out_of_range, elapsed)
    return joined


def over_objects(each: Mapping[str, SpecimenErrors]) -> MeanErrors:
    """Return the errors of the mean prediction of each object. Each object counts equally."""
    error = np.array([o.mean - o.true for o in each.values()])
    return MeanErrors(
        rmse=float(np.sqrt((error**2).mean())),
        mae=float(np.abs(error).mean()),
        mse=float((error**2).mean()),
        bias=float(error.mean()),
        n=len(error),
    )


def rank_correlation(truth: Values, score: Values, seed: int) -> RankCorrelation:
    """Return Spearman's rho of ``score`` and ``truth``, with a p-value from permutations.

    The p-value is two-sided.
    """
    from itertools import permutations
    from math import factorial

    from scipy.stats import permutation_test, rankdata, spearmanr

    n = len(truth)
    if n < 3 or np.ptp(truth) == 0 or np.ptp(score) == 0:
        return RankCorrelation(n=n)
    resamples = 9999
    if factorial(n) > resamples:
        result = permutation_test(
            (truth,),
            lambda x: spearmanr(x, score).statistic,
            permutation_type="pairings",
            n_resamples=resamples,
            rng=np.random.default_rng(seed),
        )
        return RankCorrelation(
            rho=float(result.statistic), n=n, p=float(result.pvalue), exact=False
        )
    # All permutations at once: rho is the correlation of ranks, which permuting only reorders.
    first, second = (rankdata(values) - (n + 1) / 2 for values in (truth, score))
    length = np.sqrt((first @ first) * (second @ second))
    rhos = np.array(list(permutations(first))) @ second / length
    rho = float(spearmanr(truth, score).statistic)
    smaller, larger = (rhos <= rho + 1e-9).mean(), (rhos >= rho - 1e-9).mean()
    return RankCorrelation(rho=rho, n=n, p=float(min(1.0, 2 * smaller, 2 * larger)), exact=True)
