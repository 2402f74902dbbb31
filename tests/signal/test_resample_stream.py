"""Streaming resampling gives the same output as resampling the whole signal."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.signal import CausalResampler, resample

RATES = [(48_000.0, 4936.0), (44_100.0, 4936.0), (16_000.0, 4936.0), (2200.0, 4936.0)]


@pytest.mark.parametrize(("old", "new"), RATES)
@settings(max_examples=15)
@given(sizes=st.lists(st.integers(1, 900), min_size=1, max_size=30), seed=st.integers(0, 99))
def test_blocks_of_any_size_give_the_same_output(
    old: float, new: float, sizes: list[int], seed: int
) -> None:
    x = np.random.default_rng(seed).standard_normal((sum(sizes), 2))
    stream = CausalResampler(old, new)
    out, place = [], 0
    for size in sizes:
        part, first = stream.update(x[place : place + size], place)
        assert first == sum(len(o) for o in out)
        out.append(part)
        place += size
    together = np.concatenate(out)
    np.testing.assert_allclose(together, resample(x, old, new)[: len(together)], atol=1e-12)
    assert len(together) >= len(x) * new / old - 0.0005 * new - 2


@pytest.mark.parametrize(("old", "new"), RATES)
def test_delay_is_at_most_half_a_millisecond(old: float, new: float) -> None:
    stream = CausalResampler(old, new)
    assert 0 < stream.delay <= 0.0005
    count = 0
    for k in range(round(0.05 * old)):
        out, _ = stream.update(np.zeros((1, 1)), k)
        count += len(out)
        # Of every instant up to a delay before now there is a sample.
        assert count / new + 1 / new > k / old - stream.delay - 1 / old - 1e-9


def test_sample_numbers_after_a_gap_include_the_gap() -> None:
    stream = CausalResampler(48_000.0, 4936.0)
    before_gap, first_index = stream.update(np.ones((4800, 1)), 0)
    after_gap, index_after_gap = stream.update(np.full((4800, 1), 3.0), 9600)
    assert first_index == 0
    assert index_after_gap / 4936.0 == pytest.approx(9600 / 48_000.0, abs=1 / 4936.0)
    assert index_after_gap >= len(before_gap)
    # What is missing is not made up, and what was before does not ring on behind it.
    np.testing.assert_allclose(after_gap, 3.0, rtol=1e-5)  # the filter's own ripple


def test_equal_rates_pass_samples_through() -> None:
    stream = CausalResampler(4936.0, 4936.01)
    x = np.arange(10.0)[:, None]
    out, first = stream.update(x, 5)
    assert (first, stream.delay) == (5, 0.0)
    np.testing.assert_array_equal(out, x)


@pytest.mark.parametrize(("old", "new"), [(48_000.0, 4936.0), (3000.0, 4936.0)])
def test_an_input_sample_has_the_number_of_the_nearest_output_sample(
    old: float, new: float
) -> None:
    numbers = np.array([CausalResampler(old, new).number(sample) for sample in range(5000)])
    assert np.abs(numbers / new - np.arange(5000) / old).max() <= 0.51 / new
