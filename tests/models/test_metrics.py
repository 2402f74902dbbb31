"""Scores against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models.scores import (
    CLUSTERS,
    bootstrap_interval,
    classification_scores,
    per_object,
    regression_scores,
    share_interval,
)


def test_errors_of_known_residuals() -> None:
    truth = np.array([10.0, 20.0, 30.0, 40.0])
    answers = truth + np.array([3.0, -1.0, 3.0, -1.0])
    scores = regression_scores(truth, answers, np.array(list("aabb")), 0)
    assert scores.mse == pytest.approx(5.0)
    assert scores.rmse == pytest.approx(np.sqrt(5.0))
    assert scores.mae == pytest.approx(2.0)
    assert scores.bias == pytest.approx(1.0)
    assert scores.spearman == pytest.approx(1.0)
    assert scores.n == 4


def test_clusters_are_drawn_completely() -> None:
    """Five clusters have errors 0 or 10, so resampled means are 0, 2, ..., 10."""
    errors = np.repeat([0.0, 10.0, 0.0, 10.0, 0.0], 200) / 5
    clusters = np.repeat([*"abcde"], 200)
    scores = regression_scores(np.zeros(1000), errors, clusters, 0)
    assert scores.intervals["mae"] == pytest.approx((0.0, 2.0))
    single = regression_scores(np.zeros(1000), errors, np.arange(1000), 0)
    low, high = single.intervals["mae"]
    assert 0.7 < low < 0.8 < high < 0.9


@pytest.mark.parametrize("clusters", [5, 8, 40])
def test_interval_of_few_clusters_is_as_wide_as_that_of_student(clusters: int) -> None:
    """Resampled means of a normal sample: their spread lacks the root of n / (n - 1)."""
    from scipy.stats import norm, t

    spread = np.sqrt((clusters - 1) / clusters)
    means = spread * norm.ppf((np.arange(200_000) + 0.5) / 200_000)
    low, high = bootstrap_interval(means, clusters)
    assert high == pytest.approx(-low)
    assert high == pytest.approx(t.ppf(0.975, clusters - 1), rel=0.04)


def test_few_clusters_have_no_interval_and_seeds_repeat() -> None:
    truth, answers = np.arange(5.0), np.array([1.0, 2.5, 2.0, 3.0, 3.5])
    for clusters in (1, 2, CLUSTERS - 1):
        assert regression_scores(truth, answers, np.arange(5) % clusters, 0).intervals == {}
    one, other = (regression_scores(truth, answers, np.arange(5), 5) for _ in range(2))
    assert one.intervals
    assert one == other


def test_a_side_that_does_not_vary_has_no_rank_correlation() -> None:
    scores = regression_scores(np.array([1.0, 1.0]), np.array([1.0, 2.0]), np.arange(2), 0)
    assert scores.spearman is None


def test_confusion_counts_true_rows() -> None:
    truth = np.array([10.0, 10.0, 20.0, 20.0])
    scores = classification_scores(truth, np.array([10.0, 20.0, 20.0, 20.0]), np.arange(4), 0)
    assert scores.accuracy == 0.75
    assert scores.classes == [10.0, 20.0]
    assert scores.confusion == [[1, 1], [0, 2]]


def test_each_object_by_itself_and_all_alike() -> None:
    truth = np.array([10.0, 10.0, 10.0, 40.0])
    names = np.array(["a", "a", "a", "b"])
    each = per_object(truth, np.array([11.0, 13.0, 12.0, 44.0]), names, names)
    assert each["a"].mean == pytest.approx(12.0)
    assert each["a"].bias == pytest.approx(2.0)
    assert each["a"].sd == pytest.approx(1.0)
    assert each["b"].n == 1
    assert each["b"].sd is None


@pytest.mark.parametrize("count", [0, 3, 10, 39, 40])
def test_the_interval_of_independent_pinches_is_that_of_clopper_and_pearson(count: int) -> None:
    from scipy.stats import binomtest

    hits = np.arange(40) < count
    exact = binomtest(count, 40).proportion_ci(0.95, "exact")
    # With one pinch a cluster, only the estimated variance differs: by 40 / 39.
    assert share_interval(hits, np.arange(40)) == pytest.approx(tuple(exact), abs=0.01)


@given(
    st.lists(st.booleans(), min_size=CLUSTERS, max_size=30), st.integers(1, 8), st.integers(0, 9)
)
def test_pinches_that_repeat_a_cluster_narrow_no_interval(
    shared: list[bool], each: int, seed: int
) -> None:
    hits, clusters = np.repeat(shared, each), np.repeat(np.arange(len(shared)), each)
    low, high = share_interval(hits, clusters) or (1.0, 0.0)
    assert 0.0 <= low <= hits.mean() <= high <= 1.0
    assert low < high
    order = np.random.default_rng(seed).permutation(len(hits))
    assert share_interval(hits[order], clusters[order]) == pytest.approx((low, high))
    if 0 < sum(shared) < len(shared):
        alone = share_interval(np.array(shared), np.arange(len(shared)))
        assert high - low >= 0.98 * (alone[1] - alone[0])


def test_a_share_of_few_clusters_has_no_interval() -> None:
    assert share_interval(np.ones(40, bool), np.arange(40) % (CLUSTERS - 1)) is None
