"""Signals that are clocks, or copies of each other."""

import numpy as np
import pytest

from firstcontact.core.plausible import (
    are_alike,
    clock_column_warning,
    gravity_unit_warning,
    is_clock,
    same_signal_warning,
)

N = np.arange(9000)
NOISE = np.random.default_rng(0).normal(size=(9000, 3))


@pytest.mark.parametrize(
    "clock",
    [N, N // 20, N % 256, N * 500 % 65536, 1e6 + 203.0 * N + NOISE[:, 0], np.delete(N, [7, 900])],
    ids=["counter", "milliseconds", "wraps", "wraps early", "jitters", "losses"],
)
def test_a_clock_rises_steadily(clock):
    assert is_clock(clock)
    assert clock_column_warning(["t"], [clock[:, None]])


@pytest.mark.parametrize(
    "signal",
    [
        NOISE[:, 0],
        np.round(512 + NOISE[:, 0] / 4),
        0.0 * N,
        np.cumsum(NOISE[:, 0]),
        N // 4000,
        np.maximum(N - 5000, 0),
        N[:9],
        N % 7,
    ],
    ids=["noise", "counts", "dead", "drift", "steps", "force", "short", "saw"],
)
def test_a_signal_is_no_clock(signal):
    assert not is_clock(signal)


@pytest.mark.parametrize(("factor", "noise"), [(1.0, 0.0), (-0.5, 0.0), (0.98, 0.1)])
def test_a_copy_is_alike(factor, noise):
    taps = 20 * np.exp(-(N % 1500) / 30) * np.sin(N / 3) + NOISE[:, 0]
    copy = factor * taps + noise * NOISE[:, 1]
    assert "a and b" in same_signal_warning(["a", "b"], np.column_stack([taps, copy + 5]))
    assert are_alike(NOISE[:, 0], factor * NOISE[:, 0] + noise * NOISE[:, 1], is_noise=True)


def test_other_signals_are_not_alike():
    hum = 30 * np.sin(2 * np.pi * 50 * N / 4936)
    assert not are_alike(hum + NOISE[:, 0], hum + NOISE[:, 1], is_noise=True)
    assert not same_signal_warning("abc", NOISE)
    assert not same_signal_warning("ab", np.zeros((100, 2)))  # two dead channels


@pytest.mark.parametrize(
    ("rest", "unit", "word"),
    [(1.0, "m/s2", "g"), (9.81 * 9.81, "m/s2", "m/s2"), (9.7, "m/s2", ""), (1.0, "V", "")],
)
def test_gravity_at_rest_shows_a_wrong_unit(rest: float, unit: str, word: str) -> None:
    rng = np.random.default_rng(1)
    vectors = rest * np.array([0.6, 0.0, 0.8]) + 0.01 * rng.standard_normal((300, 3))
    note = gravity_unit_warning("accelerometer", vectors, unit)
    assert (f"are in {word} and" in note) if word else not note
