"""Scores over pinches and for each object, with bootstrap intervals."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Record
from firstcontact.core.quantity import SHORE_A, Quantity
from firstcontact.models.values import Values

#: Number of resamples of a bootstrap interval.
RESAMPLES = 2000
#: Nominal coverage of every interval.
CONFIDENCE = 0.95
#: Fewest clusters for an interval. An interval over 3 holds the truth in 55 % of cases.
CLUSTERS = 5
#: Lower and upper end of an interval.
Ends = tuple[float, float]


class RegressionScores(Record, frozen=True, kw_only=True):
    """Errors over ``n`` pinches, in the unit of the target.

    ``intervals`` holds the bootstrap interval of each score by its name. Errors of a modulus or a
    stiffness are those of its natural logarithm.
    """

    rmse: float
    mae: float
    mse: float
    bias: float
    n: int
    spearman: float | None = None
    intervals: dict[str, Ends]


class ClassificationScores(Record, frozen=True, kw_only=True):
    """Accuracy (0 to 1) over ``n`` pinches, and confusion matrix (rows true, columns predicted)."""

    accuracy: float
    n: int
    classes: list[float]
    confusion: list[list[int]]
    intervals: dict[str, Ends]

    @property
    def best_constant(self) -> float:
        """Share of the most frequent class, which is the accuracy of always predicting it."""
        return max(map(sum, self.confusion), default=0) / self.n


#: Scores of a regression or a classification.
TaskScores = RegressionScores | ClassificationScores


class SpecimenErrors(Record, frozen=True, kw_only=True):
    """Mean prediction for one specimen (physical object), and errors over its ``n`` pinches."""

    object: str
    n: int
    #: Label of the specimen.
    true: float
    mean: float
    #: Standard deviation of the predictions; None for a single pinch.
    sd: float | None = None
    bias: float
    rmse: float
    mae: float
    mse: float


def _sums(clusters: NDArray[Any], columns: Values) -> Values:
    _, inverse = np.unique(clusters, return_inverse=True)
    out = np.zeros((int(inverse.max()) + 1, columns.shape[1]))
    np.add.at(out, inverse, columns)
    return out


def resampled_sums(sums: Values, seed: int) -> Values:
    """Return the sum of rows for each bootstrap resample of rows, (RESAMPLES, columns)."""
    rng, clusters = np.random.default_rng(seed), len(sums)
    return np.array([sums[rng.integers(clusters, size=clusters)].sum(0) for _ in range(RESAMPLES)])


def bootstrap_interval(values: Values, clusters: int) -> Values:
    """Return the ends of the interval of a statistic from its bootstrap values, shape (2, ...).

    ``values`` has one row per resample. The interval is wider if there are few ``clusters``.
    """
    from scipy.stats import norm, t

    wider = t.isf((1 - CONFIDENCE) / 2, clusters - 1) * np.sqrt(clusters / (clusters - 1))
    ends: Values = np.quantile(values, (norm.sf(wider), norm.cdf(wider)), axis=0)
    return ends


def cluster_intervals(
    columns: Values,
    statistics: Mapping[str, Callable[[Values], Values]],
    clusters: NDArray[Any],
    seed: int,
) -> dict[str, Ends]:
    """Return the bootstrap interval of each statistic by its name. Whole clusters are drawn.

    A statistic is a function of the sums of ``columns``, shape (n, columns). ``clusters`` names the
    cluster of each row. Return {} with fewer than ``CLUSTERS`` clusters. The method is that of
    Davison and Hinkley (1997), 3.8.
    """
    sums = _sums(clusters, columns)
    if len(sums) < CLUSTERS:
        return {}
    totals = resampled_sums(sums, seed)
    ends = {name: bootstrap_interval(of(totals), len(sums)) for name, of in statistics.items()}
    return {name: (float(low), float(high)) for name, (low, high) in ends.items()}


def regression_scores(
    truth: Values, predicted: Values, clusters: NDArray[Any], seed: int
) -> RegressionScores:
    """Return RMSE, MAE, MSE, bias and Spearman's rho of predictions, with bootstrap intervals.

    ``clusters`` names the group with which the bootstrap draws each pinch, shape (n,).
    """
    from scipy.stats import spearmanr

    error = predicted - truth
    columns = np.stack([np.ones_like(error), error, np.abs(error), error**2], axis=1)
    statistics: dict[str, Callable[[Values], Values]] = {
        "rmse": lambda s: np.sqrt(s[..., 3] / s[..., 0]),
        "mae": lambda s: s[..., 2] / s[..., 0],
        "mse": lambda s: s[..., 3] / s[..., 0],
        "bias": lambda s: s[..., 1] / s[..., 0],
    }
    total = columns.sum(axis=0)
    vary = np.ptp(truth) > 0 and np.ptp(predicted) > 0
    return RegressionScores(
        **{name: float(f(total)) for name, f in statistics.items()},
        n=len(error),
        spearman=float(spearmanr(truth, predicted).statistic) if vary else None,
        intervals=cluster_intervals(columns, statistics, clusters, seed),
    )


def share_interval(hits: NDArray[np.bool_], clusters: NDArray[Any]) -> Ends | None:
    """Return the Korn-Graubard interval of the share of ``hits``; None with few clusters.

    ``clusters`` names the cluster of each hit or miss. Fewer than ``CLUSTERS`` are too few.
    """
    from scipy.stats import beta, t

    n, share = len(hits), float(hits.mean())
    groups = len(sums := _sums(clusters, np.asarray(hits - share, float)[:, None]))
    if groups < CLUSTERS:
        return None
    variance = groups / (groups - 1) * float((sums**2).sum()) / n**2
    tail = (1 - CONFIDENCE) / 2
    worth = min(n, share * (1 - share) / variance) if variance > 1e-12 else n
    worth *= float(t.isf(tail, n - 1) / t.isf(tail, groups - 1)) ** 2
    count = share * worth
    low = 0.0 if not hits.any() else float(beta.ppf(tail, count, worth - count + 1))
    return low, 1.0 if hits.all() else float(beta.isf(tail, count + 1, worth - count))


def classification_scores(
    truth: Values, predicted: Values, clusters: NDArray[Any], seed: int
) -> ClassificationScores:
    """Return the accuracy of predicted classes with its interval, and the confusion matrix.

    ``clusters`` names the group with which each pinch is drawn, shape (n,).
    """
    right = truth == predicted
    classes = np.unique(np.concatenate([truth, predicted]))
    confusion = np.zeros((len(classes), len(classes)), np.intp)
    np.add.at(confusion, (np.searchsorted(classes, truth), np.searchsorted(classes, predicted)), 1)
    return ClassificationScores(
        accuracy=float(right.mean()),
        n=len(right),
        classes=classes.tolist(),
        confusion=confusion.tolist(),
        intervals={"accuracy": ends} if (ends := share_interval(right, clusters)) else {},
    )


def per_object(
    truth: Values,
    predicted: Values,
    specimens: NDArray[np.str_],
    objects: NDArray[np.str_],
    quantity: Quantity = SHORE_A,
) -> dict[str, SpecimenErrors]:
    """Return the mean prediction, and the errors of single pinches, for each specimen by its name.

    ``truth`` and ``predicted`` are on the scale of the quantity: logarithms for some.
    """
    out = {}
    for specimen in np.unique(specimens):
        of_specimen = specimens == specimen
        error = predicted[of_specimen] - truth[of_specimen]
        out[str(specimen)] = SpecimenErrors(
            object=str(objects[of_specimen][0]),
            n=int(of_specimen.sum()),
            true=float(quantity.restored(truth[of_specimen].mean())),
            mean=float(quantity.restored(predicted[of_specimen].mean())),
            # A single pinch has no standard deviation.
            sd=float(predicted[of_specimen].std(ddof=1)) if of_specimen.sum() > 1 else None,
            bias=float(error.mean()),
            rmse=float(np.sqrt((error**2).mean())),
            mae=float(np.abs(error).mean()),
            mse=float((error**2).mean()),
        )
    return out
