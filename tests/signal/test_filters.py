"""Common contract of all streaming filters, and the response of each."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.signal import ExponentialSmoothing, SavitzkyGolay

FILTERS = {"smoothing": ExponentialSmoothing, "savgol": SavitzkyGolay}


def noise(n: int, channels: int = 2, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n, channels))


@pytest.mark.parametrize("make", FILTERS.values(), ids=FILTERS)
@given(cuts=st.lists(st.integers(0, 60), max_size=12))
@settings(max_examples=30, deadline=None)
def test_any_split_gives_the_same_output(make, cuts):
    x = noise(60)
    expected = make().update(x)
    stream = make()
    edges = [0, *sorted(cuts), 60]
    parts = [stream.update(x[a:b]) for a, b in itertools.pairwise(edges)]
    assert np.array_equal(np.concatenate(parts), expected)


@pytest.mark.parametrize("make", FILTERS.values(), ids=FILTERS)
def test_constant_passes_unchanged(make):
    np.testing.assert_allclose(make().update(np.full((30, 1), 1.65)), 1.65, rtol=1e-14)


@pytest.mark.parametrize(
    ("make", "samples"), list(zip(FILTERS.values(), (1.0, 2.0), strict=True)), ids=FILTERS
)
def test_ramp_is_delayed_by_the_group_delay(make, samples):
    # A ramp of one a sample: the value is the time that the output speaks of.
    out = make().update(np.arange(200.0)[:, None])
    assert 199.0 - out[-1, 0] == pytest.approx(samples)


def test_smoothing_matches_the_recursion_of_the_firmware():
    x = noise(50, 1)[:, 0]
    y = [x[0]]
    for value in x[1:]:
        y.append(y[-1] + 0.5 * (value - y[-1]))
    np.testing.assert_allclose(ExponentialSmoothing(0.5).update(x[:, None])[:, 0], y, rtol=1e-12)


def test_savgol_agrees_with_scipy():
    from scipy.signal import savgol_filter

    x = noise(50, 1)[:, 0]
    ours = SavitzkyGolay().update(x[:, None])[:, 0]
    np.testing.assert_allclose(ours[2:], savgol_filter(x, 5, 2)[2:-2], atol=1e-12)


def test_savgol_output_uses_nothing_beyond_its_lookahead():
    x = noise(30, 1)
    changed = x.copy()
    changed[20:] += 100.0
    one = SavitzkyGolay()
    a, b = one.update(x), SavitzkyGolay().update(changed)
    assert np.array_equal(a[: 20 - one.lookahead], b[: 20 - one.lookahead])
    assert len(a) == 30 - one.lookahead


@pytest.mark.parametrize("alpha", [0.0, 1.5])
def test_impossible_settings_are_refused(alpha):
    with pytest.raises(ValueError, match="alpha"):
        ExponentialSmoothing(alpha)
