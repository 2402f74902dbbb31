"""Scores against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models import (
    classification_scores,
    cluster_intervals,
    per_object,
    regression_scores,
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
    clusters = np.arange(len(error)) % 3
    scores = regression_scores(truth, truth + error, clusters, seed)
    assert scores.rmse**2 == pytest.approx(scores.mse)
    assert scores.rmse >= scores.mae - 1e-9
    assert scores.mae >= abs(scores.bias) - 1e-9
    for low, high in scores.intervals.values():
        assert low <= high + 1e-9


def test_clusters_are_drawn_completely() -> None:
    """Two clusters have errors 0 and 2, so resampled means are 0, 1 or 2."""
    errors = np.repeat([0.0, 2.0], 500)
    clusters = np.repeat(["a", "b"], 500)
    scores = regression_scores(np.zeros(1000), errors, clusters, 0)
    assert scores.intervals["mae"] == (0.0, 2.0)
    single = regression_scores(np.zeros(1000), errors, np.arange(1000), 0)
    low, high = single.intervals["mae"]
    assert 0.9 < low < 1.0 < high < 1.1


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


def test_one_cluster_has_no_interval_and_seeds_repeat() -> None:
    truth, answers = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.5, 2.0])
    assert regression_scores(truth, answers, np.array(["a"] * 3), 0).intervals == {}
    one, other = (regression_scores(truth, answers, np.arange(3), 5) for _ in range(2))
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
