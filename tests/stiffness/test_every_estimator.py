"""Every registered estimator keeps the promises of the protocol. New ones are found by name."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from toy_windows import RATE, toy_windows

from firstcontact.core import InputError
from firstcontact.stiffness import (
    ESTIMATORS,
    Card,
    Estimator,
    LearnedFrom,
    Model,
    Task,
    load_model,
    make_estimator,
    save_model,
)
from firstcontact.stiffness.registry import model_kind

pytestmark = [
    pytest.mark.parametrize("name", ESTIMATORS),
    pytest.mark.parametrize("task", Task),
]
CARD = Card(data=LearnedFrom(source="synthetic", pinches=180, sessions=("0",)))


def made(name: str, task: Task) -> Estimator:
    return make_estimator(name, task, RATE, **ESTIMATORS[name].quick)


@cache
def fitted(name: str, task: Task) -> Model:
    return made(name, task).fit(*toy_windows(), seed=3)


def test_it_is_an_estimator(name: str, task: Task) -> None:
    estimator = made(name, task)
    assert isinstance(estimator, Estimator)
    assert (estimator.name, estimator.task, estimator.rate) == (name, task, RATE)
    assert model_kind(fitted(name, task).kind) is type(fitted(name, task))


def test_predictions_are_one_number_a_window(name: str, task: Task) -> None:
    model, (X, y, _) = fitted(name, task), toy_windows(40, seed=1)
    predicted = model.predict(X)
    assert predicted.shape == (40,)
    assert predicted.dtype == np.float64
    assert np.isfinite(predicted).all()
    assert model.predict(X[:0]).shape == (0,)
    assert model.spec.samples == X.shape[1]
    assert model.spec.duration == pytest.approx(0.015, rel=1e-3)
    if task is Task.CLASSIFICATION:
        assert set(predicted) <= set(model.spec.classes) == set(y)


def test_one_window_is_answered_like_many(name: str, task: Task) -> None:
    model, (X, _, _) = fitted(name, task), toy_windows(40, seed=1)
    one = [model.predict_one(window) for window in X]
    assert all(type(answer) is float for answer in one)
    # Kernel sums in float32, in another order: a few thousandths of a Shore.
    np.testing.assert_allclose(model.predict(X), one, atol=0.02)


def test_no_window_changes_another_ones_answer(name: str, task: Task) -> None:
    model, (X, _, _) = fitted(name, task), toy_windows(40, seed=1)
    np.testing.assert_allclose(model.predict(X)[::-1], model.predict(X[::-1]), atol=0.02)


def test_same_seed_same_model(name: str, task: Task) -> None:
    again = made(name, task).fit(*toy_windows(), seed=3).to_arrays()
    for key, array in fitted(name, task).to_arrays().items():
        np.testing.assert_array_equal(array, again[key], err_msg=key)


def test_training_leaves_its_input_alone(name: str, task: Task) -> None:
    X, y, groups = toy_windows(60)
    before = X.copy(), y.copy(), groups.copy()
    made(name, task).fit(X, y, groups).predict(X)
    for array, copy in zip((X, y, groups), before, strict=True):
        np.testing.assert_array_equal(array, copy)


def test_a_saved_model_answers_the_same(name: str, task: Task, tmp_path: Path) -> None:
    model, (X, _, _) = fitted(name, task), toy_windows(40, seed=1)
    loaded = load_model(save_model(model, tmp_path / "mödel", CARD))
    assert loaded.spec == model.spec
    assert dict(loaded.notes) == dict(model.notes)
    np.testing.assert_array_equal(loaded.predict(X), model.predict(X))
    assert loaded.predict_one(X[0]) == model.predict_one(X[0])


@pytest.mark.parametrize("shape", [(73, 1), (75, 1), (74, 2), (74,), (0, 1)])
def test_another_shape_is_refused(name: str, task: Task, shape: tuple[int, ...]) -> None:
    window = np.ones(shape, dtype=np.float32)
    with pytest.raises(InputError, match="takes windows of"):
        fitted(name, task).predict_one(window)
    with pytest.raises(InputError, match="takes windows of"):
        fitted(name, task).predict(window[None])


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_window_that_is_not_finite_is_refused(name: str, task: Task, value: float) -> None:
    X = toy_windows(5)[0]
    X[3, 7, 0] = value
    with pytest.raises(InputError, match="not finite"):
        fitted(name, task).predict_one(X[3])
    with pytest.raises(InputError, match="window 3"):
        fitted(name, task).predict(X)
    with pytest.raises(InputError, match="window 3"):
        made(name, task).fit(X, np.arange(5.0))


@pytest.mark.parametrize("level", [0.0, 1.65])
def test_a_flat_window_is_refused(name: str, task: Task, level: float) -> None:
    X = toy_windows(5)[0]
    X[2] = level
    with pytest.raises(InputError, match="constant"):
        fitted(name, task).predict_one(X[2])
    with pytest.raises(InputError, match="window 2"):
        fitted(name, task).predict(X)


def test_another_rate_is_refused(name: str, task: Task) -> None:
    fitted(name, task).spec.require_rate(RATE * 1.001)
    for rate in (16000.0, RATE / 2, np.nan):
        with pytest.raises(InputError, match="firstcontact train --rate"):
            fitted(name, task).spec.require_rate(rate)


def test_targets_that_do_not_fit_are_refused(name: str, task: Task) -> None:
    X, y, groups = toy_windows(20)
    with pytest.raises(InputError, match="as many"):
        made(name, task).fit(X, y[:-1])
    with pytest.raises(InputError, match="as many"):
        made(name, task).fit(X, y, groups[:-1])
    with pytest.raises(InputError, match="no target"):
        made(name, task).fit(X, np.where(np.arange(20) == 4, np.nan, y))
    with pytest.raises(InputError, match="at least two windows"):
        made(name, task).fit(X[:1], y[:1])


def test_it_learns_more_than_the_mean(name: str, task: Task) -> None:
    X, y, _ = toy_windows(90, seed=9)
    error = np.sqrt(np.mean((fitted(name, task).predict(X) - y) ** 2))
    floor = np.sqrt(np.mean((fitted("train_mean", task).predict(X) - y) ** 2))
    assert error <= floor
    if name != "train_mean":
        assert error < 0.7 * floor


@pytest.mark.parametrize(("samples", "channels"), [(10, 1), (240, 1), (74, 2)])
def test_other_lengths_and_two_channels(name: str, task: Task, samples: int, channels: int) -> None:
    X, y, groups = toy_windows(48, samples, channels)
    model = made(name, task).fit(X, y, groups)
    assert model.spec.channels == channels
    np.testing.assert_allclose(
        model.predict(X[:3]), [model.predict_one(x) for x in X[:3]], atol=0.02
    )


def test_it_learns_from_very_few(name: str, task: Task) -> None:
    X, y, _ = toy_windows(40)
    few = np.array([np.flatnonzero(y == level)[0] for level in np.unique(y)])
    assert np.isfinite(made(name, task).fit(X[few], y[few]).predict(X)).all()
