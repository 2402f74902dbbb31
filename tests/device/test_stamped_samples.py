"""Tests of sample numbers from stamps: gaps, jitter and drift."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.device._stamped_samples import StampedSamples

RATE = 1000.0


def numbers(stamps: np.ndarray, chunk: int) -> np.ndarray:
    along = StampedSamples(RATE)
    parts = [along.numbers(stamps[k : k + chunk]) for k in range(0, len(stamps), chunk)]
    return np.concatenate(parts)


@settings(max_examples=40)
@given(
    lost=st.lists(st.integers(0, 900), max_size=60),
    chunk=st.integers(2, 80),
    drift=st.floats(-2e-4, 2e-4),
)
def test_regular_stamps_tell_every_gap(lost: list[int], chunk: int, drift: float) -> None:
    # Most steps of a chunk are regular: lone losses, as they are.
    kept = np.setdiff1d(np.arange(1000), [n for n in set(lost) if n % 7 == 3])
    found = numbers(100.0 + kept / RATE * (1 + drift), chunk)
    np.testing.assert_array_equal(found, kept - kept[0])


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("jitter", [0.5, 5.0])
def test_jitter_and_drift_are_no_gaps(seed: int, jitter: float) -> None:
    rng = np.random.default_rng(seed)
    true = np.arange(20_000)
    stamps = true / RATE * (1 + 1e-4) + jitter / RATE * rng.standard_normal(len(true))
    np.testing.assert_array_equal(numbers(stamps, 25), true)


@pytest.mark.parametrize("seed", range(5))
def test_a_gap_among_jittering_stamps_is_as_long_as_it_was(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true = np.concatenate([np.arange(3000), np.arange(3400, 6000)])
    stamps = true / RATE + 5.0 / RATE * rng.standard_normal(len(true))
    found = numbers(stamps, 25)
    assert abs(found[-1] - true[-1]) < 10
    np.testing.assert_array_equal(found[:2950], true[:2950])


def of_chunks(true: np.ndarray, sent: int, held_up: np.ndarray) -> np.ndarray:
    """Return stamps as LSL makes them for chunks: the last sample has the time of sending."""
    of = np.arange(len(true)) // sent
    last = np.minimum((of + 1) * sent, len(true)) - 1
    return (true[last] - (last - np.arange(len(true)))) / RATE + held_up[of]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("sent", [10, 32])
def test_chunks_that_are_sent_late_are_no_gaps(seed: int, sent: int) -> None:
    # All steps within a chunk are regular; between two, time goes forward and back.
    rng = np.random.default_rng(seed)
    true = np.arange(30_000)
    held_up = np.abs(rng.normal(0.0, 0.002, len(true) // sent + 1))
    found = numbers(of_chunks(true, sent, held_up), 100)
    assert 0 <= found[-1] - true[-1] <= 10  # before the first step back nothing tells them


def test_a_chunk_that_was_held_up_once_is_no_gap_and_one_that_lacks_is() -> None:
    rng = np.random.default_rng(0)
    true = np.concatenate([np.arange(8000), np.arange(8500, 16_000)])
    held_up = rng.uniform(0.0, 0.002, len(true) // 20 + 1)
    held_up[200] += 0.05
    found = numbers(of_chunks(true, 20, held_up), 20)
    assert abs(found[7900] - 7900) <= 5
    assert abs(found[-1] - true[-1]) <= 5
    np.testing.assert_array_equal(np.diff(found[8050:]), 1)
