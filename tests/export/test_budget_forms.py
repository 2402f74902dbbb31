"""Intervals of smaller models grow by the differences from the full model's predictions."""

import numpy as np
import pytest
from test_model_parity import INTERVAL, learned

from firstcontact.core import InputError
from firstcontact.export.budget import forms, small_enough
from firstcontact.models import ESTIMATORS, Model, Task, make_estimator
from firstcontact.models.model import shipped_model
from firstcontact.models.windows.window_predictor import WindowPredictor
from firstcontact.testing import closings
from firstcontact.testing.synthetic import RATE, toy_windows


def test_a_smaller_form_has_a_wider_interval() -> None:
    X, y, sessions = toy_windows()
    # What cannot be learned takes many vectors.
    noisy = y + np.random.default_rng(0).normal(0, 6, len(y))
    estimator = make_estimator(
        ESTIMATORS.default, Task.REGRESSION, RATE, **ESTIMATORS[ESTIMATORS.default].quick
    )
    named = WindowPredictor(estimator.fit(X, noisy, sessions, seed=1), INTERVAL)
    *smaller, complete = forms(named, X, sessions.astype(str))
    assert complete is named
    assert smaller
    new = toy_windows(60, seed=5)[0]
    for form in smaller:
        grown = np.subtract(form.interval.half_widths, named.interval.half_widths)
        assert (grown >= 0).all()
        np.testing.assert_allclose(grown, grown[0])
        away = np.abs(form.model.predict(new) - named.model.predict(new))
        assert (away <= 3 * grown[0] + 1e-6).mean() > 0.8


def test_without_an_interval_there_is_nothing_to_widen() -> None:
    named = learned(ESTIMATORS.default, Task.CLASSIFICATION)
    X, _, sessions = toy_windows()
    assert all(form.interval is None for form in forms(named, X, sessions.astype(str)))


def test_window_models_are_held_to_the_budget() -> None:
    model = Model(None, (learned(ESTIMATORS.default, Task.REGRESSION),))
    with pytest.raises(InputError, match="--budget-us"):
        small_enough(model, None, 1.0)


def test_a_network_is_left_as_it_is() -> None:
    model = shipped_model()
    assert small_enough(model, closings(8), 30.0).predictors == model.predictors
