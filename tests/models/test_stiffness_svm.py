"""SVM in NumPy: equal to scikit-learn's, with hyper-parameters chosen on inner folds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.core import InputError
from firstcontact.models import Task, make_estimator
from firstcontact.models.splits import inner_folds
from firstcontact.models.svm import LEVEL_WEIGHT, SvmModel, shape_and_level, svm_machine
from firstcontact.testing.synthetic import RATE, toy_windows


@pytest.mark.parametrize("classes", [2, 3, 5])
def test_votes_are_scikit_learns(classes: int) -> None:
    rng = np.random.default_rng(classes)
    X = rng.normal(size=(300, 20, 1)).astype(np.float32)
    y = rng.integers(0, classes, 300).astype(float)  # no structure: margins of all signs
    model = make_estimator("svm", Task.CLASSIFICATION, RATE).fit(X, y)
    arrays = model.to_arrays()
    machine = svm_machine(Task.CLASSIFICATION, tuple(arrays["parameters"]))
    machine.fit(shape_and_level(X, arrays["level"]), y)
    queries = rng.normal(size=(500, 20, 1)).astype(np.float32)
    expected = machine.predict(shape_and_level(queries, arrays["level"]))
    np.testing.assert_array_equal(model.predict(queries), expected)


def test_regression_is_scikit_learns() -> None:
    X, y, groups = toy_windows(300)
    model = make_estimator("svm", Task.REGRESSION, RATE).fit(X, y, groups)
    arrays = model.to_arrays()
    mean, deviation = arrays["target"]
    machine = svm_machine(Task.REGRESSION, tuple(arrays["parameters"]))
    machine.fit(shape_and_level(X, arrays["level"]), (y - mean) / deviation)
    queries = toy_windows(100, seed=5)[0]
    expected = machine.predict(shape_and_level(queries, arrays["level"])) * deviation + mean
    np.testing.assert_allclose(model.predict(queries), expected, atol=0.02)


@pytest.mark.parametrize("task", Task)
def test_a_large_set_is_fitted_to_a_sample_that_has_every_class(
    task: Task, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("firstcontact.models.svm.MOST_WINDOWS", 60)
    rng = np.random.default_rng(0)
    X = rng.normal(size=(500, 20, 1)).astype(np.float32)
    y = np.where(np.arange(500) == 321, 90.0, np.where(np.arange(500) % 2, 10.0, 50.0))
    model = make_estimator("svm", task, RATE).fit(X, y)
    assert len(model.to_arrays()["vectors"]) <= 61
    if task is Task.CLASSIFICATION:
        assert model.spec.classes == (10.0, 50.0, 90.0)
        assert {10.0, 50.0, 90.0} >= set(model.predict(X)) >= {10.0, 50.0}


@given(gain=st.floats(0.1, 10.0))
def test_gain_moves_the_level_and_nothing_else(gain: float) -> None:
    X = toy_windows(6)[0]
    level = np.array([-2.0, 0.5])
    original, current = shape_and_level(X, level), shape_and_level(X * np.float32(gain), level)
    np.testing.assert_allclose(current[:, :-1], original[:, :-1], rtol=1e-4, atol=1e-5)
    moved = np.log(gain) / level[1] * LEVEL_WEIGHT
    np.testing.assert_allclose(current[:, -1] - original[:, -1], moved, rtol=1e-3, atol=1e-4)


@given(
    seed=st.integers(0, 100),
    k=st.integers(2, 5),
    sessions=st.integers(2, 12),
    values=st.sampled_from([1, 2, 5, 40]),
)
@settings(max_examples=60)
def test_folds_spread_the_targets_of_sessions(
    seed: int, k: int, sessions: int, values: int
) -> None:
    """If all sessions have the same targets, so do all folds, and no fold is empty."""
    groups = np.repeat(np.arange(sessions), 40)
    y = np.tile(np.arange(40) % values, sessions).astype(float)
    folds = list(inner_folds(y, groups, seed, k))
    assert len(folds) == min(k, sessions)
    sizes = [len(np.unique(groups[held_out])) for _, held_out in folds]
    assert max(sizes) - min(sizes) <= 1
    for _, held_out in folds:
        np.testing.assert_allclose(y[held_out].mean(), y.mean())


def test_one_window_has_no_folds() -> None:
    assert list(inner_folds(np.ones(1), None, 0)) == []


def test_arrays_of_two_machines_do_not_mix() -> None:
    X, y, groups = toy_windows(60)
    model = make_estimator("svm", Task.REGRESSION, RATE).fit(X, y, groups)
    arrays = model.to_arrays()
    with pytest.raises(InputError, match="train again"):
        SvmModel.from_arrays(model.spec, arrays | {"vectors": arrays["vectors"][:-1]})
