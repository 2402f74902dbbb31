"""Losses in time stamps of several kinds of senders, and delays without a loss."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from firstcontact.recording._runs import lost_samples

RATE = 2000.0
SAMPLES = 40_000
Values = np.ndarray[Any, np.dtype[Any]]
Sender = Callable[[Values, np.random.Generator], Values]


def last_of_chunk(n, size):
    """Return the last sample of the chunk of each of ``n`` samples."""
    return np.minimum((np.arange(n) // size + 1) * size, n) - 1


def regular(times, rng):
    return times + rng.uniform(0.0, 0.1 / RATE, len(times))


def jittering(times, rng):
    return times + 0.002 * rng.standard_normal(len(times))


def one_stamp_per_chunk(times, rng):
    last = last_of_chunk(len(times), 40)
    return times[last] + rng.exponential(0.002, len(times))[last]


def counted_back_from_chunks(times, rng):
    last = last_of_chunk(len(times), 64)
    delays = rng.exponential(0.002, len(times))[last]
    return times[last] - (last - np.arange(len(times))) / RATE + delays


def stalling(times, rng):
    """Return stamps of a sender that stops now and then, and then catches up."""
    stamps = times.copy()
    for begin in rng.uniform(times[0], times[-1], 5):
        end = begin + rng.uniform(0.05, 0.4)
        stamps[(times >= begin) & (times < end)] = end
    return stamps + rng.exponential(1e-4, len(times))


SENDERS = [regular, jittering, one_stamp_per_chunk, counted_back_from_chunks, stalling]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("sender", SENDERS)
def test_jitter_delays_and_drift_are_no_losses(sender, seed):
    rng = np.random.default_rng(seed)
    times = 1000.0 + np.arange(SAMPLES) / RATE * (1 + rng.uniform(-3e-4, 3e-4))
    assert lost_samples(sender(times, rng), RATE) == []


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("lasting", [3.0, 10.0])
def test_slowly_changing_delays_are_no_losses(lasting, seed):
    n, chunk = 120_000, 40
    rng = np.random.default_rng(seed)
    decay = math.exp(-chunk / RATE / lasting)
    noise = rng.standard_normal(n // chunk) * 0.003 * math.sqrt(1 - decay**2)
    delay = np.abs(lfilter([1.0], [1.0, -decay], noise))
    stamps = np.arange(n)[chunk - 1 :: chunk] / RATE + delay
    assert lost_samples(np.repeat(np.maximum.accumulate(stamps), chunk), RATE) == []


def test_a_delay_that_lasts_and_ends_is_no_loss():
    rng = np.random.default_rng(0)
    times = np.arange(160_000) / RATE
    late = np.where((times > 20) & (times < 50), 0.02, 0.0)
    stamps = np.maximum.accumulate(times + late) + rng.exponential(0.001, len(times))
    assert lost_samples(stamps, RATE) == []


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("sender", SENDERS)
def test_losses_in_all_stamps_are_at_their_places(sender, seed):
    rng = np.random.default_rng(seed)
    losses = np.sort(rng.integers([6000, 18_000, 30_000], [12_000, 24_000, 34_000]))
    received = np.delete(np.arange(SAMPLES), [k + i for k in losses for i in range(100)])
    stamps = sender(1000.0 + received / RATE, rng)
    places = np.flatnonzero(np.diff(received) > 1) + 1
    # Within a chunk, stamps do not reveal the place. A delay hides it, too.
    tolerance = {regular: 0, jittering: 5, stalling: 800}.get(sender, 64)
    np.testing.assert_allclose(lost_samples(stamps, RATE), places, atol=tolerance)


@settings(max_examples=40)
@given(lost=st.sets(st.integers(1, 900), max_size=60), drift=st.floats(-2e-3, 2e-3))
def test_regular_stamps_reveal_each_loss(lost, drift):
    received = np.setdiff1d(np.arange(1000), list(lost))
    expected = np.flatnonzero(np.diff(received) > 1) + 1
    assert lost_samples(100.0 + received / RATE * (1 + drift), RATE) == expected.tolist()


@pytest.mark.parametrize("n", [0, 1, 2, 100])
def test_few_stamps_have_no_losses(n):
    assert lost_samples(np.zeros(n), RATE) == []
