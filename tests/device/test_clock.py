"""Clocks: device and host, and sample numbers from stamps with gaps, jitter and drift."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from firstcontact.core import Block
from firstcontact.device.clock import SLEW, ClockFit, DeviceClock, RateCheck, TransportDelay
from firstcontact.device.stamped_samples import StampedSamples

RATE = 4936.0


def feed(clock: ClockFit, ppm: float, seconds: float, jitter: float, seed: int = 0) -> None:
    """Yield blocks of 1 ms with random delays: mostly short ones, sometimes long ones."""
    rng = np.random.default_rng(seed)
    samples = np.arange(5, round(seconds * RATE), 5)
    true = samples / (RATE * (1 + 1e-6 * ppm))
    late = rng.exponential(jitter, len(samples))
    late[rng.random(len(samples)) < 0.001] += 0.05
    # What waits is overtaken by nothing.
    hosts = 1e5 + np.maximum.accumulate(true + late)
    for sample, host in zip(samples.tolist(), hosts.tolist(), strict=True):
        clock.add(sample, host)


@pytest.mark.parametrize("ppm", [-100.0, 0.0, 100.0])
def test_drift_is_within_1_ppm_after_a_minute(ppm: float) -> None:
    clock = ClockFit(RATE)
    feed(clock, ppm, 60, 2e-4)
    assert clock.rate == pytest.approx(RATE * (1 + 1e-6 * ppm), rel=1e-6)


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


@pytest.mark.parametrize(
    ("rate", "longest"),
    [(500.0, 1.3), (2500.0, 1.3), (10_000.0, 1.3), (50_000.0, 1.3), (4850.0, 2.3), (5150.0, 2.3)],
)
def test_rate_error_is_refused_soon(rate: float, longest: float) -> None:
    refusal = refusal_time(*arrivals(rate, 5.0))
    assert refusal <= longest


@pytest.mark.parametrize("seed", range(4))
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


RATE = 4936.0


def stamps(clock: DeviceClock, first: int, n: int, host: float, epoch: int = 0) -> list[float]:
    return clock.stamps(Block(np.zeros((n, 16), np.int16), first, epoch), host).tolist()


ARRIVALS = st.lists(
    st.tuples(
        st.integers(1, 400),  # samples
        st.integers(0, 2000),  # lost before them
        st.floats(0.0, 30.0),  # since the last arrival, s
        st.sampled_from([0, 0, 0, 0, 1]),  # whether the device started anew
    ),
    min_size=1,
    max_size=30,
)


@given(ARRIVALS, st.floats(0, 1e6))
def test_stamps_increase_for_any_arrivals(
    arrivals: list[tuple[int, int, float, int]], host: float
) -> None:
    clock, times, first, epoch = DeviceClock(RATE), [], 0, 0
    for n, gap, delay, restarted in arrivals:
        epoch += restarted
        first = gap if restarted else first + gap
        host += delay
        times += stamps(clock, first, n, host, epoch)
        first += n
        assert clock.host_time(first - 1, epoch) == times[-1]
    assert (np.diff(times) > 0).all()


def test_stamps_follow_drift_without_jitter() -> None:
    """Blocks are up to 20 ms late, and the clock is 100 ppm fast."""
    rng = np.random.default_rng(0)
    clock, worst = DeviceClock(RATE), 0.0
    for k in range(0, 300_000, 25):
        true = 7.0 + np.arange(k, k + 25) / (RATE * (1 + 100e-6))
        delay = 0.0 if rng.random() < 0.05 else rng.exponential(0.004)
        estimate = stamps(clock, k, 25, true[-1] + min(delay, 0.02))
        if k > RATE:
            worst = max(worst, float(np.abs(np.array(estimate) - true).max()))
    assert worst < 1.5e-3


def test_small_offset_is_corrected_slowly() -> None:
    """The first block came 100 ms late. Later blocks pull the stamps back gradually."""
    clock = DeviceClock(RATE)
    times = stamps(clock, 0, 5, 0.1 + 4 / RATE)
    for k in range(5, 30_000, 5):
        times += stamps(clock, k, 5, (k + 4) / RATE)
    steps = np.diff(times) * RATE
    assert steps.min() >= 1 - SLEW - 1e-6
    assert steps.max() <= 1 + SLEW + 1e-6
    assert abs(times[-1] - 29_999 / RATE) < 1e-9


@given(st.lists(st.floats(0.0, 0.3), min_size=1, max_size=40), st.integers(1, 200))
def test_transport_delay_is_relative_to_the_shortest(delays: list[float], n: int) -> None:
    transport, host = TransportDelay(RATE), 0.0
    least = np.inf
    for k, delay in enumerate(delays):
        sampled = 20.0 + (n * (k + 1) - 1) / RATE
        host = max(host, sampled + delay)
        transport.add(Block(np.zeros((n, 16), np.int16), n * k), host)
        least = min(least, host - sampled)
        assert abs(transport.delay(n * (k + 1) - 1, host) - (host - sampled - least)) < 1e-9


STAMPED = 1000.0


def numbers(stamps: np.ndarray, chunk: int) -> np.ndarray:
    along = StampedSamples(STAMPED)
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
    sample_numbers = numbers(100.0 + true_numbers / STAMPED * (1 + drift), chunk)
    np.testing.assert_array_equal(sample_numbers, true_numbers - true_numbers[0])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("jitter", [0.5, 5.0])
def test_jitter_and_drift_are_no_gaps(seed: int, jitter: float) -> None:
    rng = np.random.default_rng(seed)
    true = np.arange(20_000)
    stamps = true / STAMPED * (1 + 1e-4) + jitter / STAMPED * rng.standard_normal(len(true))
    np.testing.assert_array_equal(numbers(stamps, 25), true)


@pytest.mark.parametrize("seed", range(5))
def test_gap_in_jittering_stamps_has_about_its_length(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true = np.concatenate([np.arange(3000), np.arange(3400, 6000)])
    stamps = true / STAMPED + 5.0 / STAMPED * rng.standard_normal(len(true))
    sample_numbers = numbers(stamps, 25)
    assert abs(sample_numbers[-1] - true[-1]) < 10
    np.testing.assert_array_equal(sample_numbers[:2950], true[:2950])


def chunk_stamps(true: np.ndarray, chunk_size: int, delays: np.ndarray) -> np.ndarray:
    """Return stamps as LSL makes them for chunks: the last sample has the time of sending."""
    chunk_index = np.arange(len(true)) // chunk_size
    last = np.minimum((chunk_index + 1) * chunk_size, len(true)) - 1
    return (true[last] - (last - np.arange(len(true)))) / STAMPED + delays[chunk_index]


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
