"""Tests of the device's clock: a simulated hour, late blocks, jumps and restarts."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.device._clock import ClockFit

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


@pytest.mark.slow
@pytest.mark.parametrize("ppm", [-100.0, 100.0])
def test_an_hour_of_drift(ppm: float) -> None:
    clock = ClockFit(RATE)
    feed(clock, ppm, 3600, 1e-3)
    assert clock.rate == pytest.approx(RATE * (1 + 1e-6 * ppm), rel=2e-7)


@pytest.mark.parametrize("rate", [2468.0, 4700.0, 5000.0])
def test_rate_away_from_the_nominal_one_is_estimated(rate: float) -> None:
    clock = ClockFit(RATE)
    for sample in range(0, 100_000, 5):
        clock.add(sample, 7.0 + sample / rate)
    assert clock.rate == pytest.approx(rate, rel=1e-9)


def test_lost_samples_do_not_change_the_drift() -> None:
    clock = ClockFit(RATE)
    for sample in range(0, 100_000, 5):
        if not 30_000 < sample < 60_000:
            clock.add(sample, 7.0 + sample / RATE)
    assert clock.rate == pytest.approx(RATE, rel=1e-9)


def test_no_drift_is_reported_before_enough_data() -> None:
    clock = ClockFit(RATE)
    assert clock.rate == 0.0
    feed(clock, 50.0, 4, 1e-4)
    assert clock.rate == 0.0
