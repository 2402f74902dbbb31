"""SVM in NumPy: equal to scikit-learn's, with hyper-parameters chosen on inner folds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.models import Task, make_estimator
from firstcontact.models.splits import inner_folds
from firstcontact.models.windows.svm import LEVEL_WEIGHT, shape_and_level, svm_machine
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
    monkeypatch.setattr("firstcontact.models.windows.svm.MOST_WINDOWS", 60)
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


def test_one_window_has_no_folds() -> None:
    assert list(inner_folds(np.ones(1), None, 0)) == []
