"""Tests of the closing speed that the twin's hand measures. Measuring has no side effects."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pinches import EVERYDAY

from firstcontact.core import Label
from firstcontact.recording import load_dataset
from firstcontact.twin import (
    BLOCKS,
    draw_pinch,
    draw_specimen,
    simulate,
    simulate_pinch,
)
from firstcontact.twin._drive import Positions


def test_the_measured_speed_is_that_of_the_drives() -> None:
    deviations = []
    for number in range(12):
        specimen = draw_specimen(5, EVERYDAY, BLOCKS[number % 5], 0)
        draw = draw_pinch(5, EVERYDAY, "one", specimen, number)
        sensor = Positions(np.random.default_rng(number))
        pinch = simulate_pinch(draw, Label(), 1000, positions=sensor)
        measured = pinch.closing_speed
        assert measured is not None
        true = np.mean([finger.speed for finger in draw.fingers])
        deviations.append((measured.speed - true) / measured.error)
        assert 0.003 < measured.error / measured.speed < 0.06
    assert np.abs(deviations).max() < 5
    assert 0.3 < np.std(deviations) < 2.0


def test_positions_leave_the_samples_alone(tmp_path: Path) -> None:
    simulate(tmp_path / "with", "everyday", 1, 1, 3, 1, positions=True)
    simulate(tmp_path / "without", "everyday", 1, 1, 3, 1)
    measured, plain = load_dataset(tmp_path / "with"), load_dataset(tmp_path / "without")
    for one, other in zip(measured, plain, strict=True):
        np.testing.assert_array_equal(one.data, other.data)
        assert one.truth == other.truth
        assert one.closing_speed is not None
        assert other.closing_speed is None
