"""Features of the log-spectrum model: they depend on the frequency, but not on the loudness."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import InputError
from firstcontact.models import Task, make_estimator
from firstcontact.models.windows.log_spectrum import (
    BANDS,
    KINDS,
    LogSpectrumModel,
    _evenly,
    features,
    log_bands,
)

RATE = 4936.0


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
    weights = _evenly(Task.CLASSIFICATION, y, groups)
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
