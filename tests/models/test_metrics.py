"""Scores against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models import (
    CLUSTERS,
    bootstrap_interval,
    classification_scores,
    cluster_intervals,
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


@given(st.lists(st.floats(-50, 50), min_size=3, max_size=30), st.integers(0, 3))
def test_rmse_and_mae_and_bias_keep_their_order(errors: list[float], seed: int) -> None:
    error = np.array(errors)
    truth = np.linspace(0, 60, len(error))
    clusters = np.arange(len(error)) % 6
    scores = regression_scores(truth, truth + error, clusters, seed)
    assert scores.rmse**2 == pytest.approx(scores.mse)
    assert scores.rmse >= scores.mae - 1e-9
    assert scores.mae >= abs(scores.bias) - 1e-9
    for low, high in scores.intervals.values():
        assert low <= high + 1e-9


def test_clusters_are_drawn_completely() -> None:
    """Five clusters have errors 0 or 10, so resampled means are 0, 2, ..., 10."""
    errors = np.repeat([0.0, 10.0, 0.0, 10.0, 0.0], 200) / 5
    clusters = np.repeat([*"abcde"], 200)
    scores = regression_scores(np.zeros(1000), errors, clusters, 0)
    assert scores.intervals["mae"] == pytest.approx((0.0, 2.0))
    single = regression_scores(np.zeros(1000), errors, np.arange(1000), 0)
    low, high = single.intervals["mae"]
    assert 0.7 < low < 0.8 < high < 0.9


def test_interval_of_a_mean_agrees_with_theory() -> None:
    rng = np.random.default_rng(1)
    values = rng.standard_normal(400)
    columns = np.stack([np.ones(400), values], axis=1)
    low, high = cluster_intervals(
        columns, {"mean": lambda s: s[..., 1] / s[..., 0]}, np.arange(400), 0
    )["mean"]
    half = 1.96 * values.std() / 20
    assert low == pytest.approx(values.mean() - half, abs=0.15 * half)
    assert high == pytest.approx(values.mean() + half, abs=0.15 * half)


@pytest.mark.parametrize("clusters", [5, 8, 40])
def test_interval_of_few_clusters_is_as_wide_as_that_of_student(clusters: int) -> None:
    """Resampled means of a normal sample: their spread lacks the root of n / (n - 1)."""
    from scipy.stats import norm, t

    spread = np.sqrt((clusters - 1) / clusters)
    means = spread * norm.ppf((np.arange(200_000) + 0.5) / 200_000)
    low, high = bootstrap_interval(means, clusters)
    assert high == pytest.approx(-low)
    assert high == pytest.approx(t.ppf(0.975, clusters - 1), rel=0.04)


def test_intervals_of_few_clusters_hold_the_truth_more_often_than_percentiles() -> None:
    rng = np.random.default_rng(2)
    held = np.zeros(2)
    for _ in range(200):
        values = rng.standard_normal(8)
        drawn = values[rng.integers(8, size=(2000, 8))].mean(axis=1)
        ends = bootstrap_interval(drawn, 8), np.quantile(drawn, (0.025, 0.975))
        held += [low <= 0.0 <= high for low, high in ends]
    assert held[0] > held[1] + 5
    assert held[0] > 0.9 * 200


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


def test_a_single_class_has_a_confusion_of_one_number() -> None:
    scores = classification_scores(np.full(4, 10.0), np.full(4, 10.0), np.arange(4), 0)
    assert scores.confusion == [[4]]
    assert scores.classes == [10.0]


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
        assert alone is not None
        assert high - low >= 0.98 * (alone[1] - alone[0])


def test_shares_of_clustered_pinches_are_held_more_often_than_by_a_bootstrap() -> None:
    rng = np.random.default_rng(3)
    clusters, held = np.repeat(np.arange(12), 20), np.zeros(2)
    for repeat in range(200):
        hits = rng.random(240) < np.repeat(rng.beta(49, 1, 12), 20)  # a share of 0.98
        columns = np.stack([np.ones(240), hits], axis=1)
        plain = cluster_intervals(
            columns, {"share": lambda s: s[..., 1] / s[..., 0]}, clusters, repeat
        )["share"]
        ours = share_interval(hits, clusters)
        assert ours is not None
        held += [low <= 0.98 <= high for low, high in (ours, plain)]
    assert held[0] > max(held[1], 0.93 * 200)


def test_a_share_of_few_clusters_has_no_interval() -> None:
    assert share_interval(np.ones(40, bool), np.arange(40) % (CLUSTERS - 1)) is None
