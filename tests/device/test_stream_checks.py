"""Tests of the checks of live samples: values in range, and the stated rate."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.device._clock import RateCheck

STATED = 5000.0


def refusal_time(times: np.ndarray, ends: np.ndarray) -> float | None:
    """Return the time after which a stream of arrivals is refused, s; None if it is accepted."""
    check = RateCheck(STATED)
    for seconds, end in zip(times.tolist(), ends.tolist(), strict=True):
        if check.add(end, seconds):
            return seconds - float(times[0])
    return None


def arrivals(rate: float, seconds: float, jitter: float = 0.0, seed: int = 0) -> np.ndarray:
    """Yield times and numbers of chunks of 5 ms with random delays, in order."""
    times = np.arange(0.005, seconds, 0.005)
    late = np.abs(np.random.default_rng(seed).normal(0.0, jitter, len(times)))
    return np.stack([np.maximum.accumulate(times + late), np.floor(times * rate)])


@pytest.mark.parametrize("rate", [500.0, 2500.0, 10_000.0, 50_000.0])
def test_large_rate_error_is_refused_within_a_second(rate: float) -> None:
    refusal = refusal_time(*arrivals(rate, 5.0))
    assert refusal is not None
    assert refusal <= 1.3


@pytest.mark.parametrize("rate", [4850.0, 5150.0])
def test_rate_error_of_3_percent_is_refused_within_two_seconds(rate: float) -> None:
    refusal = refusal_time(*arrivals(rate, 5.0))
    assert refusal is not None
    assert refusal <= 2.3


@pytest.mark.parametrize(
    "seed", [*range(4), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(4, 20))]
)
@pytest.mark.parametrize("jitter", [0.0, 0.002, 0.02, 0.1])
def test_jitter_within_the_tolerance_is_not_refused(jitter: float, seed: int) -> None:
    for rate in (4940.0, 5060.0):
        assert refusal_time(*arrivals(rate, 60.0, jitter, seed)) is None


@pytest.mark.parametrize("begin", [0.0, 0.1, 0.6, 3.0])
def test_backlog_of_any_length_is_not_refused(begin: float) -> None:
    check = RateCheck(STATED)
    number = 0.0
    for millisecond in range(20_000):
        behind = begin < 1e-3 * millisecond < begin + 6.0
        number += 35.0 if behind else 5.0
        assert not check.add(number, 1e-3 * millisecond, behind=behind)
    assert check.rate == pytest.approx(STATED)


@pytest.mark.parametrize("begin", [0.0, 0.1, 0.6, 1.0, 3.0, 9.0])
@pytest.mark.parametrize("loses_samples", [False, True])
def test_stall_of_five_seconds_is_not_refused(begin: float, loses_samples: bool) -> None:
    times, ends = arrivals(STATED, 30.0)
    stalled = (times > begin) & (times < begin + 5.0)
    if loses_samples:  # as without a counter: the samples of the stall never come
        ends = ends - np.cumsum(np.diff(ends, prepend=0.0) * stalled)
    times = np.where(stalled, begin + 5.0 + 0.01 * (times - begin) / 5.0, times)
    assert refusal_time(np.maximum.accumulate(times), ends) is None


def test_backlog_before_the_start_is_not_refused() -> None:
    times, ends = arrivals(STATED, 20.0)
    assert refusal_time(np.concatenate([[0.0, 0.001], times]), np.r_[0, 9000, ends + 9000]) is None
