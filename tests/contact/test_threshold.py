"""Published threshold detector against a square wave."""

import numpy as np
import pytest

from firstcontact.contact import ThresholdDetector
from firstcontact.contact.contacts import judge_windows
from firstcontact.core import Block
from firstcontact.testing.synthetic import LAYOUT

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
    verdicts = judge_windows(ThresholdDetector(), LAYOUT, stream(height, 400))
    assert verdicts.fired.any() == fires


def test_a_contact_is_placed_in_its_window_however_short_its_steps_are():
    class Short(ThresholdDetector):
        name = "short"
        step, reach = 0.0002, 1

    verdicts = judge_windows(Short(), LAYOUT, stream(10.0, 400))
    assert verdicts.fired.any()
    assert np.abs(verdicts.onsets[verdicts.fired] - 400).max() <= 3


def test_crossing_fires_in_one_window():
    verdicts = judge_windows(ThresholdDetector(), LAYOUT, stream(10.0, 400))
    row = (400 - STEADY) // STEP
    assert np.argwhere(verdicts.fired).tolist() == [[row, 0]]
    assert verdicts.ends[row] - STEP < 400 <= verdicts.ends[row]
