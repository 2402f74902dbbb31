"""Window models: baselines, log spectrum, and the SVM with its hyper-parameters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import InputError
from firstcontact.models import Task, make_estimator
from firstcontact.models.splits import inner_folds
from firstcontact.models.windows.baselines import Peak, TrainMean
from firstcontact.models.windows.log_spectrum import (
    BANDS,
    KINDS,
    LogSpectrumModel,
    _even_weights,
    features,
    log_bands,
)
from firstcontact.models.windows.svm import LEVEL_WEIGHT, shape_and_level, svm_machine
from firstcontact.testing.synthetic import RATE, toy_windows


def rings(hertz: np.ndarray, seed: int = 0, samples: int = 74) -> np.ndarray:
    """Return damped oscillations with a little noise, shape (n, samples, 1)."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) / RATE
    waves = np.sin(2 * np.pi * hertz[:, None] * t) * np.exp(-t / 0.006)
    return (waves + 0.01 * rng.standard_normal(waves.shape)).astype(np.float32)[:, :, None]


@pytest.mark.parametrize("kind", KINDS)
@given(st.floats(1e-6, 1e6), st.sampled_from([10, 15, 25, 39, 74, 300]))
def test_gain_is_not_heard(kind: str, gain: float, samples: int) -> None:
    X = rings(np.array([150.0, 600.0, 1800.0]), samples=samples)
    computed = features(kind, X, RATE)
    assert np.isfinite(computed).all()
    assert features(kind, np.float32(gain) * X, RATE) == pytest.approx(computed, abs=1e-3)


@given(st.floats(150.0, 2000.0))
def test_a_tone_is_in_its_band(hertz: float) -> None:
    edges = np.geomspace(100.0, RATE / 2, BANDS + 1)
    band = log_bands(rings(np.array([hertz]))[:, :, 0].astype(float), RATE)[0].argmax()
    # Damping makes it broad: its own band or a neighbour.
    assert abs(int(band) - int(np.searchsorted(edges, hertz) - 1)) <= 1


@pytest.mark.parametrize("task", list(Task))
def test_it_moves_to_a_sensor_with_another_gain(task: Task) -> None:
    rng = np.random.default_rng(1)
    y = np.repeat([0.0, 1.0], 60)
    hertz = np.where(y > 0, 900.0, 300.0) * np.exp(0.1 * rng.standard_normal(len(y)))
    sensors = np.tile(["a", "b", "c"], 40)
    X = rings(hertz) * np.exp(rng.standard_normal((len(y), 1, 1))).astype(np.float32)
    model = make_estimator("log_spectrum", task, RATE).fit(X, y, sensors)
    other = 100 * rings(hertz, seed=5)
    assert (np.round(model.predict(other)) == y).mean() > 0.95


@given(st.lists(st.tuples(st.integers(0, 2), st.sampled_from("abc")), min_size=1, max_size=60))
def test_groups_count_alike_and_so_do_classes(pairs: list[tuple[int, str]]) -> None:
    y = np.array([float(c) for c, _ in pairs])
    groups = np.array([g for _, g in pairs])
    weights = _even_weights(Task.CLASSIFICATION, y, groups)
    assert weights.mean() == pytest.approx(1.0)
    of_classes = [weights[y == c].sum() for c in np.unique(y)]
    assert of_classes == pytest.approx([of_classes[0]] * len(of_classes))
    for c in np.unique(y):
        of_groups = [weights[(y == c) & (groups == g)].sum() for g in np.unique(groups[y == c])]
        assert of_groups == pytest.approx([of_groups[0]] * len(of_groups))


def test_arrays_that_do_not_fit_are_refused() -> None:
    y = np.repeat([0.0, 1.0], 10)
    model = make_estimator("log_spectrum", Task.CLASSIFICATION, RATE).fit(rings(300 + 500 * y), y)
    arrays = model.to_arrays()
    for name, wrong in (
        ("kind", np.array([9.0])),
        ("kind", np.array([np.nan])),
        ("weights", arrays["weights"][1:]),
        ("scale", np.zeros_like(arrays["scale"])),
    ):
        with pytest.raises(InputError, match="train again"):
            LogSpectrumModel.from_arrays(model.spec, {**arrays, name: wrong})


def windows(peaks: np.ndarray) -> np.ndarray:
    """Return windows with these peaks."""
    shape = np.sin(np.linspace(0, np.pi, 11))
    return (peaks[:, None] * shape)[:, :, None].astype(np.float32)


def test_the_mean_and_the_most_frequent_class() -> None:
    X, y = windows(np.arange(1.0, 6.0)), np.array([10.0, 10.0, 10.0, 43.0, 60.0])
    assert TrainMean(Task.REGRESSION, RATE).fit(X, y).predict(X[:1]) == y.mean()
    assert TrainMean(Task.CLASSIFICATION, RATE).fit(X, y).predict(X[4:]) == 10.0


def test_the_peak_finds_a_parabola_and_stays_in_its_range() -> None:
    peaks = np.geomspace(0.01, 1.0, 50)
    y = 50 + 12 * np.log(peaks) + 1.5 * np.log(peaks) ** 2
    model = Peak(Task.REGRESSION, RATE).fit(windows(peaks), y)
    np.testing.assert_allclose(model.predict(windows(peaks)), y, atol=1e-3)
    assert model.predict(windows(np.array([1e3])))[0] == y.max()


def test_the_peak_takes_the_nearest_class() -> None:
    peaks = np.array([0.1, 0.11, 1.0, 1.1, 10.0, 11.0])
    y = np.repeat([10.0, 29.0, 60.0], 2)
    model = Peak(Task.CLASSIFICATION, RATE).fit(windows(peaks), y)
    np.testing.assert_array_equal(model.predict(windows(np.array([0.09, 0.9, 30.0]))), [10, 29, 60])
    np.testing.assert_array_equal(model.predict(-windows(peaks)), y)  # either direction counts


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
