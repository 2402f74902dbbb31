"""Tests of the drives' reference speed between two commands."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import FINGERTIP_RATE, Command
from firstcontact.twin import Drive
from firstcontact.twin._drive import DriveReference

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


@given(SPEEDS, SPEEDS, st.integers(-1, 500))
def test_hold_keeps_the_speed(speed: float, hold_speed: float, sample: int) -> None:
    reference = DriveReference(Drive(force=9.0), speed)
    reference.obey(Command(0.1, 2.0), 10)
    assert reference.force == 2.0
    reference.hold(hold_speed)
    assert reference.command is None
    assert reference.force == 9.0
    assert reference.speed(sample) == hold_speed


def test_new_command_starts_at_the_current_speed() -> None:
    reference = DriveReference(Drive(), 0.13)
    reference.obey(Command(0.0, 12.0), 100)
    on_the_way = reference.speed(130)
    assert 0 < on_the_way < 0.13
    reference.obey(Command(0.13, 12.0), 130)
    assert reference.speed(130) == on_the_way
    assert reference.speed(131) == pytest.approx(on_the_way + 10 / FINGERTIP_RATE)
