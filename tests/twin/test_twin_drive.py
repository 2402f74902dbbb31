"""Tests of the drives' reference speed between two commands, and of their position sensor."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pinches import EVERYDAY

from firstcontact.core import Command, Label
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.recording import load_dataset
from firstcontact.twin import BLOCKS, draw_pinch, simulate_pinch
from firstcontact.twin.draw import draw_specimen
from firstcontact.twin.drive import Drive, DriveReference, Positions
from firstcontact.twin.simulation import simulate_recordings

SPEEDS = st.floats(-0.25, 0.25)


@given(SPEEDS, SPEEDS, st.integers(0, 500), st.integers(1, 300))
def test_speed_changes_no_faster_than_the_acceleration(
    speed: float, commanded: float, sample: int, intervals: int
) -> None:
    drive = Drive()
    reference = DriveReference(drive, speed)
    assert (reference.speeds(sample, intervals) == speed).all()
    reference.obey(Command(commanded, 3.0), sample)
    speeds = np.array([speed, *reference.speeds(sample, 400)])
    assert np.abs(np.diff(speeds)).max() <= drive.acceleration / FINGERTIP_RATE * (1 + 1e-9)
    assert (np.sign(np.diff(speeds)) * np.sign(commanded - speed) >= 0).all()
    assert speeds[-1] == commanded
    assert reference.speed(sample + intervals) == speeds[intervals]
    later_speeds = reference.speeds(sample + intervals, 50)
    assert (later_speeds == reference.speeds(sample, intervals + 50)[intervals:]).all()


def test_new_command_starts_at_the_current_speed() -> None:
    reference = DriveReference(Drive(), 0.13)
    reference.obey(Command(0.0, 12.0), 100)
    on_the_way = reference.speed(130)
    assert 0 < on_the_way < 0.13
    reference.obey(Command(0.13, 12.0), 130)
    assert reference.speed(130) == on_the_way
    assert reference.speed(131) == pytest.approx(on_the_way + 10 / FINGERTIP_RATE)


def test_the_measured_speed_is_that_of_the_drives() -> None:
    deviations = []
    for number in range(12):
        specimen = draw_specimen(5, EVERYDAY, BLOCKS[number % 5], 0)
        draw = draw_pinch(5, EVERYDAY, "one", specimen, number)
        sensor = Positions(np.random.default_rng(number))
        pinch = simulate_pinch(draw, Label(), 1000, positions=sensor)
        measured = pinch.closing_speed
        true = np.mean([finger.speed for finger in draw.fingers])
        deviations.append((measured.speed - true) / measured.error)
        assert 0.003 < measured.error / measured.speed < 0.06
    assert np.abs(deviations).max() < 5
    assert 0.3 < np.std(deviations) < 2.0


def test_positions_leave_the_samples_alone(tmp_path: Path) -> None:
    simulate_recordings(tmp_path / "with", "everyday", 1, 1, 3, 1, positions=True)
    simulate_recordings(tmp_path / "without", "everyday", 1, 1, 3, 1)
    measured, plain = load_dataset(tmp_path / "with"), load_dataset(tmp_path / "without")
    for one, other in zip(measured, plain, strict=True):
        np.testing.assert_array_equal(one.data, other.data)
        assert one.truth == other.truth
        assert one.closing_speed is not None
        assert other.closing_speed is None
