"""Baselines: the training mean and the peak amplitude."""

import numpy as np

from firstcontact.models import Task
from firstcontact.models.windows.baselines import Peak, TrainMean
from firstcontact.testing.synthetic import RATE


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
