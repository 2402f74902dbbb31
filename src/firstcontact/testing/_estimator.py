"""Check of an estimator that learns from windows, such as that of a plug-in."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.installation import missing_modules
from firstcontact.models import (
    ESTIMATORS,
    Estimator,
    Model,
    Task,
    WindowModel,
    WindowPredictor,
    load_model,
)
from firstcontact.testing.synthetic import RATE, refused, toy_windows

#: Largest difference between the predictions for a window alone and among other windows, in Shore
#: A. Sums in float32 depend on their order.
SLACK = 0.02


def check_estimator(estimator_class: type[Estimator], task: Task | None = None) -> None:
    """Assert that an estimator behaves as its base class requires, on synthetic windows.

    Parameters
    ----------
    estimator_class
        Class of the estimator. Saving and loading are checked only if the class is registered.
    task
        Task for which the estimator is checked; by default each of its tasks.

    Raises
    ------
    AssertionError
        A check failed (the message names it), or there was nothing to check.
    """
    tasks = estimator_class.tasks if task is None else (task,)
    assert tasks, f"{estimator_class.__name__} has no tasks: there is nothing to check"
    assert set(tasks) <= set(estimator_class.tasks), (
        f"{estimator_class.__name__} does not support {task}"
    )
    assert estimator_class.name, "the estimator has no name"
    assert estimator_class.title, "the estimator has no title"
    missing = missing_modules(estimator_class.modules)
    assert not missing, f"{', '.join(missing)} must be installed to check {estimator_class.name}"
    for each in tasks:
        make = partial(estimator_class, each, RATE, **estimator_class.quick)
        _check_training(make, each)
        model = make().fit(*toy_windows(), seed=3)
        assert isinstance(model, estimator_class.model), (
            f"the estimator's models are {type(model).__name__}"
        )
        _check_predictions(model, each)
        _check_refusals(model, make)
        _check_shapes(make)
        _check_saved(estimator_class, model)


def _check_training(make: Callable[[], Estimator], task: Task) -> None:
    X, y, groups = toy_windows(60)
    estimator = make()
    assert (estimator.task, estimator.rate) == (task, RATE), "task and rate are not stored"
    given: list[NDArray[Any]] = [X, y, groups]
    copies = [array.copy() for array in given]
    model = estimator.fit(X, y, groups, seed=3)
    for array, copy in zip(given, copies, strict=True):
        assert np.array_equal(array, copy), "training changes the training data"
    again = make().fit(X, y, groups, seed=3).to_arrays()
    for name, array in model.to_arrays().items():
        assert np.array_equal(array, again[name]), f"same seed, another model: array {name}"
    subset = np.array([np.flatnonzero(y == level)[0] for level in np.unique(y)])
    predictions = make().fit(X[subset], y[subset]).predict(X)
    assert np.isfinite(predictions).all(), "the estimator cannot be trained on one window per level"
    refused("60 targets and sessions", lambda: make().fit(X, y[:-1]))
    refused("60 targets and sessions", lambda: make().fit(X, y, groups[:-1]))
    refused("no target", lambda: make().fit(X, np.where(np.arange(60) == 4, np.nan, y)))
    refused("training needs windows of shape (2 or more", lambda: make().fit(X[:1], y[:1]))


def _check_predictions(model: WindowModel, task: Task) -> None:
    X, y, _ = toy_windows(90, seed=9)
    predictions = model.predict(X)
    assert predictions.shape == (90,), "there is not one prediction per window"
    assert predictions.dtype == np.float64, "predictions are not float64"
    assert model.predict(X[:0]).shape == (0,), "there are predictions without windows"
    alone = [model.predict(window[None])[0] for window in X]
    assert np.allclose(predictions, alone, rtol=0, atol=SLACK), (
        "a window changes another window's prediction"
    )
    if task is Task.CLASSIFICATION:
        assert set(predictions) <= set(model.spec.classes) == set(y), "a prediction is not a class"
        assert (predictions == y).mean() >= 1 / 3, "worse than chance on an easy task"
    else:
        error, spread = np.sqrt(np.mean((predictions - y) ** 2)), y.std()
        assert error <= 1.05 * spread, "worse than the mean on an easy task"
    spreads = model.spread(X)
    if spreads is not None:
        assert spreads.shape == (90,), "there is not one spread per window"
        assert (spreads > 0).all(), "a spread is not above 0"
        assert np.isfinite(spreads).all(), "a spread is not finite"
        spreads_alone = [model.spread(window[None])[0] for window in X[:5]]  # type: ignore[index]
        assert np.allclose(spreads[:5], spreads_alone), (
            "the spread of a window depends on other windows"
        )


def _check_refusals(model: WindowModel, make: Callable[[], Estimator]) -> None:
    for shape in ((73, 1), (74, 2), (74,)):
        refused("windows of shape", partial(model.predict, np.ones((1, *shape), np.float32)))
    for value in (np.nan, np.inf):
        X = toy_windows(5)[0]
        X[3, 7, 0] = value
        refused("window 3", partial(model.predict, X))
        refused("window 3", partial(make().fit, X, np.arange(5.0)))
    for level in (0.0, 1.65):
        X = toy_windows(5)[0]
        X[2] = level
        refused("window 2", partial(model.predict, X))
    model.spec.require_rate(RATE * 1.001)
    for rate in (16000.0, RATE / 2, np.nan):
        refused("firstcontact train --rate", partial(model.spec.require_rate, rate))


def _check_shapes(make: Callable[[], Estimator]) -> None:
    for samples, channels in ((10, 1), (240, 1), (74, 2)):
        X, y, groups = toy_windows(48, samples, channels)
        model = make().fit(X, y, groups)
        assert (model.spec.samples, model.spec.channels) == (samples, channels), (
            "the model has another window shape"
        )
        assert model.predict(X[:3]).shape == (3,), "there is not one prediction per window"


def _check_saved(estimator_class: type[Estimator], model: WindowModel) -> None:
    if ESTIMATORS.get(estimator_class.name) is not estimator_class:
        return
    X = toy_windows(40, seed=1)[0]
    with tempfile.TemporaryDirectory() as folder:
        saved = Model(predictors=(WindowPredictor(model),)).save(Path(folder) / "mödel")
        loaded = load_model(saved).windows[0].model
    assert loaded.spec == model.spec, "the model's spec changes by saving and loading"
    assert dict(loaded.notes) == dict(model.notes), "the model's notes change by saving and loading"
    assert np.array_equal(loaded.predict(X), model.predict(X)), (
        "the model's predictions change by saving and loading"
    )
