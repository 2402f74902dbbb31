"""Tests of sample numbers from stamps: gaps, jitter and drift."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.device.stamped_samples import StampedSamples

RATE = 1000.0


def numbers(stamps: np.ndarray, chunk: int) -> np.ndarray:
    along = StampedSamples(RATE)
    parts = [along.numbers(stamps[k : k + chunk]) for k in range(0, len(stamps), chunk)]
    return np.concatenate(parts)


@settings(max_examples=40)
@given(
    lost_samples=st.lists(st.integers(0, 900), max_size=60),
    chunk=st.integers(2, 80),
    drift=st.floats(-2e-4, 2e-4),
)
def test_regular_stamps_reveal_every_gap(lost_samples: list[int], chunk: int, drift: float) -> None:
    # Most steps of a chunk are regular: lone losses, as they are.
    true_numbers = np.setdiff1d(np.arange(1000), [n for n in set(lost_samples) if n % 7 == 3])
    sample_numbers = numbers(100.0 + true_numbers / RATE * (1 + drift), chunk)
    np.testing.assert_array_equal(sample_numbers, true_numbers - true_numbers[0])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("jitter", [0.5, 5.0])
def test_jitter_and_drift_are_no_gaps(seed: int, jitter: float) -> None:
    rng = np.random.default_rng(seed)
    true = np.arange(20_000)
    stamps = true / RATE * (1 + 1e-4) + jitter / RATE * rng.standard_normal(len(true))
    np.testing.assert_array_equal(numbers(stamps, 25), true)


@pytest.mark.parametrize("seed", range(5))
def test_gap_in_jittering_stamps_has_about_its_length(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true = np.concatenate([np.arange(3000), np.arange(3400, 6000)])
    stamps = true / RATE + 5.0 / RATE * rng.standard_normal(len(true))
    sample_numbers = numbers(stamps, 25)
    assert abs(sample_numbers[-1] - true[-1]) < 10
    np.testing.assert_array_equal(sample_numbers[:2950], true[:2950])


def chunk_stamps(true: np.ndarray, chunk_size: int, delays: np.ndarray) -> np.ndarray:
    """Return stamps as LSL makes them for chunks: the last sample has the time of sending."""
    chunk_index = np.arange(len(true)) // chunk_size
    last = np.minimum((chunk_index + 1) * chunk_size, len(true)) - 1
    return (true[last] - (last - np.arange(len(true)))) / RATE + delays[chunk_index]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("chunk_size", [10, 32])
def test_late_chunks_are_no_gaps(seed: int, chunk_size: int) -> None:
    # All steps within a chunk are regular; between two, time goes forward and back.
    rng = np.random.default_rng(seed)
    true = np.arange(30_000)
    delays = np.abs(rng.normal(0.0, 0.002, len(true) // chunk_size + 1))
    sample_numbers = numbers(chunk_stamps(true, chunk_size, delays), 100)
    assert 0 <= sample_numbers[-1] - true[-1] <= 10  # before the first step back nothing tells them


def test_delayed_chunk_is_no_gap_but_a_missing_one_is() -> None:
    rng = np.random.default_rng(0)
    true = np.concatenate([np.arange(8000), np.arange(8500, 16_000)])
    delays = rng.uniform(0.0, 0.002, len(true) // 20 + 1)
    delays[200] += 0.05
    sample_numbers = numbers(chunk_stamps(true, 20, delays), 20)
    assert abs(sample_numbers[7900] - 7900) <= 5
    assert abs(sample_numbers[-1] - true[-1]) <= 5
    np.testing.assert_array_equal(np.diff(sample_numbers[8050:]), 1)
