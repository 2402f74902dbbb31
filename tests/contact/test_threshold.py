"""Published threshold detector against a square wave."""

from __future__ import annotations

import numpy as np
import pytest

from firstcontact.contact import ThresholdDetector
from firstcontact.core import Block
from firstcontact.testing._closings import LAYOUT

STEADY, STEP = 197, 15


def stream(height: float, position: int) -> Block:
    """Return a square wave of known sigma with one sample of another height."""
    x = np.tile([1.0, -1.0], 300) * 320
    x[position] = height * 320
    data = np.full((600, 16), 16384.0)
    data[:, 0] += x
    return Block(data)


@pytest.mark.parametrize(("height", "fires"), [(2.9, False), (3.1, True), (-3.1, True)])
def test_fires_above_three_sigmas(height, fires):
    detector = ThresholdDetector()
    detector.start(LAYOUT)
    assert detector.judge(stream(height, 400)).fired.any() == fires


def test_crossing_fires_in_one_window():
    detector = ThresholdDetector()
    detector.start(LAYOUT)
    verdicts = detector.judge(stream(10.0, 400))
    row = (400 - STEADY) // STEP
    assert np.argwhere(verdicts.fired).tolist() == [[row, 0]]
    assert verdicts.ends[row] - STEP < 400 <= verdicts.ends[row]


def test_steady_state_is_replaced_only_where_a_channel_is_quieter() -> None:
    rng = np.random.default_rng(6)
    detector = ThresholdDetector(3.0)
    detector.start(LAYOUT)
    size = detector.steady_samples
    data = np.zeros((size, LAYOUT.width), np.int16)
    data[:, :2] = 16384 + rng.integers(-90, 90, (size, 2))
    detector.resettle(np.ones((size, 2)))  # before the first steady state there is none to replace
    detector.judge(Block(data, 0))
    assert detector._state is not None
    mean, sigma = detector._state.mean, detector._state.sigma
    later = mean + rng.normal(0, 1, (size, 2)) * sigma * [0.5, 0.95]
    detector.resettle(later)
    assert detector._state.sigma[0] == pytest.approx(later[:, 0].std())
    assert (detector._state.mean[1], detector._state.sigma[1]) == (mean[1], sigma[1])
    detector.resettle(np.zeros((size, 2)))  # a dead channel is not a quiet one
    assert (detector._state.sigma > 0.0).all()
