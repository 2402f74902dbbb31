"""Tests of sample times: they follow the device's clock and never go back."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Block
from firstcontact.device import DeviceClock, TransportDelay
from firstcontact.device._clock import SLEW

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


def test_stamps_without_delay_are_the_arrival_times() -> None:
    clock = DeviceClock(RATE)
    for k in range(100):
        last = stamps(clock, 5 * k, 5, 50.0 + (5 * k + 4) / RATE)
        np.testing.assert_allclose(last, 50.0 + np.arange(5 * k, 5 * k + 5) / RATE, atol=1e-9)


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


def test_stamps_follow_a_tenfold_replay_speed() -> None:
    clock = DeviceClock(RATE)
    for k in range(0, 200_000, 50):
        last = stamps(clock, k, 50, 0.1 * (k + 49) / RATE)
    assert abs(last[-1] - 0.1 * 199_999 / RATE) < 0.3


def test_a_gap_shows_in_the_stamps() -> None:
    clock = DeviceClock(RATE)
    before_gap = stamps(clock, 0, 100, 99 / RATE)
    after_gap = stamps(clock, 600, 100, 699 / RATE)
    assert abs(after_gap[0] - before_gap[-1] - 501 / RATE) < 1e-9


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
