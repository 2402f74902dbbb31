"""Tests of a pinch that is simulated in pieces, with orders within the drive's limits."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from pinches import EVERYDAY, PAPER_RIG, drawn

from firstcontact.core import Command, InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin import BLOCKS, TwinObject
from firstcontact.twin._run import PinchRun
from firstcontact.twin.draw import Condition, PinchDraw
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import CONTACT_FORCE, DRIVE_SPEED, INDENTATION
from firstcontact.twin.noise import MotorNoise
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact.twin.pinch import BURN_IN, DURATION, integrate_pinch

ALL = BURN_IN + round(DURATION * FINGERTIP_RATE)
SILENT = MotorNoise(rotor=0.0, mesh=0.0, friction=0.0, click_rate=0.0, mains=0.0)
DT = 1 / FINGERTIP_RATE


def same(a: NDArray[np.float64], b: NDArray[np.float64]) -> bool:
    return a.tobytes() == b.tobytes()


def pieces(run: PinchRun, edges: list[int]) -> NDArray[np.float64]:
    return np.concatenate([run.advance(b - a) for a, b in pairwise(edges) if b > a])


@settings(max_examples=20)
@given(
    st.sampled_from([BLOCKS[0], BLOCKS[4], EVERYDAY_OBJECTS[4]]),
    st.sampled_from([PAPER_RIG, EVERYDAY]),
    st.lists(st.integers(1, ALL - 1), max_size=8),
)
def test_any_pieces_give_the_same_bytes(
    kind: TwinObject, condition: Condition, cuts: list[int]
) -> None:
    run = PinchRun(drawn(kind, 1, condition), DURATION, BURN_IN)
    out = pieces(run, [0, *sorted(cuts), ALL])
    times, expected = integrate_pinch(drawn(kind, 1, condition))
    assert same(out[BURN_IN:], expected)
    assert same(run.times[BURN_IN:] - BURN_IN / FINGERTIP_RATE, times)


@settings(max_examples=20)
@given(st.lists(st.integers(1, ALL - 1), max_size=6), st.sampled_from([0.05, -0.1, 0.0]))
def test_command_takes_effect_at_its_sample_for_any_pieces(cuts: list[int], speed: float) -> None:
    at = 800

    def commanded(edges: list[int]) -> NDArray[np.float64]:
        run = PinchRun(drawn(BLOCKS[2]), DURATION, BURN_IN)
        before = pieces(run, sorted({0, at, *(e for e in edges if e < at)}))
        run.speed = speed
        after = pieces(run, sorted({at, ALL, *(e for e in edges if e > at)}))
        return np.concatenate([before, after])

    assert same(commanded(cuts), commanded([]))


def test_a_still_run_stays_still() -> None:
    run = PinchRun(drawn(BLOCKS[1]), 0.5, at_rest=True)
    out = run.advance(run.times.size)
    assert not out[..., :INDENTATION].any()
    assert run.touched == (False, False)


@pytest.mark.parametrize("share", [1.0, 0.5, 0.25])
def test_slower_hand_touches_proportionally_later(share: float) -> None:
    timing = drawn(BLOCKS[2], 3).timing
    run = PinchRun(drawn(BLOCKS[2], 3), 1.0, at_rest=True)
    run.speed = share * run.nominal_speed
    closed = run.advance(run.times.size)[..., INDENTATION] > 0
    touched = np.sort(closed.argmax(axis=0)) / FINGERTIP_RATE
    assert touched == pytest.approx(np.array(timing[:2]) / share, abs=1.1 / FINGERTIP_RATE)


def test_motor_noise_follows_the_loudness() -> None:
    run = PinchRun(drawn(BLOCKS[2]), 1.0, at_rest=True)
    quiet = run.advance(1000)[..., 0].std()
    run.loudness = 1.0
    run.advance(500)
    loud = run.advance(1000)[..., 0].std()
    run.loudness = 0.0
    run.advance(1000)
    faded = run.advance(1000)[..., 0].std()
    assert quiet == 0 < loud
    assert faded < 1e-3 * loud


@pytest.mark.parametrize("samples", [0, -1, ALL + 1])
def test_advancing_past_the_end_is_refused(samples: int) -> None:
    with pytest.raises(ValueError, match=f"{samples} samples"):
        PinchRun(drawn(BLOCKS[0]), DURATION, BURN_IN).advance(samples)


def quiet_draw(number: int = 0) -> PinchDraw:
    return replace(drawn(BLOCKS[1], number), noise=(SILENT, SILENT), jitter=0.0)


def start_run(draw: PinchDraw, drive: Drive, samples: int, duration: float = 1.0) -> PinchRun:
    run = PinchRun(draw, duration, BURN_IN, drive, damped=True)
    run.advance(BURN_IN + samples)
    return run


def order(run: PinchRun, command: Command, drive: Drive) -> None:
    run.order(command, run.done - 1 + drive.delay)


@pytest.mark.parametrize("latency", [0.0, 0.013, 0.02, 0.08])
def test_command_takes_effect_after_exactly_the_latency(latency: float) -> None:
    drive = Drive(latency=latency)
    run = start_run(quiet_draw(), drive, 100)
    reference = start_run(quiet_draw(), drive, 100)
    reference.order(Command(reference.nominal_speed, 12.0), reference.done - 1)
    order(run, Command(0.0, 12.0), drive)
    speeds = [r.advance(450)[..., DRIVE_SPEED].mean(axis=1) for r in (run, reference)]
    first_change = int(np.argmax(speeds[0] != speeds[1]))
    # The sample after the interval in which the reference first was another.
    assert first_change == round(latency * FINGERTIP_RATE)


@pytest.mark.parametrize("latency", [0.0, 0.02, 0.05])
@pytest.mark.parametrize("acceleration", [5.0, 10.0, 15.0])
def test_stopping_distance_has_its_closed_form(latency: float, acceleration: float) -> None:
    drive = Drive(latency=latency, acceleration=acceleration)
    draw = quiet_draw()
    run = start_run(draw, drive, 20)
    order(run, Command(0.0, 12.0), drive)
    speed = run.nominal_speed
    moved = run.advance(590)[..., DRIVE_SPEED].mean(axis=1)
    assert abs(moved[-1]) < 1e-4
    # The speed loop follows its reference late by mass over gain.
    p = draw.fingers[0]
    late = (p.drive_mass + p.phalanx_mass + p.board_mass + p.skin_mass) / p.speed_gain
    expected = speed * latency + speed**2 / (2 * acceleration) + speed * late
    assert moved.sum() * DT == pytest.approx(expected, abs=1.5 * speed * DT)


def test_newest_command_wins_and_each_takes_effect_in_turn() -> None:
    drive = Drive()

    def speeds(*commands: Command) -> NDArray[np.float64]:
        run = start_run(quiet_draw(), drive, 20)
        for command in commands:
            order(run, command, drive)
        return run.advance(500)[..., DRIVE_SPEED].mean(axis=1)

    slow, stop = Command(0.05, 12.0), Command(0.0, 12.0)
    assert (speeds(slow, stop) == speeds(stop)).all()
    run = start_run(quiet_draw(), drive, 20)
    order(run, stop, drive)
    run.advance(50)
    order(run, slow, drive)
    moved = run.advance(450)[..., DRIVE_SPEED].mean(axis=1)
    assert moved[40:149].min() < 0.7 * run.nominal_speed
    assert moved[-1] == pytest.approx(0.05, abs=1e-3)


@pytest.mark.parametrize("number", range(4))
def test_command_at_the_drawn_speed_keeps_the_contact_times(number: int) -> None:
    timing = drawn(BLOCKS[2], number).timing
    run = start_run(drawn(BLOCKS[2], number), Drive(latency=0.0), 20)
    order(run, Command(run.nominal_speed, 12.0), Drive(latency=0.0))
    closed = run.advance(1500)[..., INDENTATION] > 0
    assert closed.any(axis=0).all()
    contact_times = (20 + np.sort(closed.argmax(axis=0))) * DT
    assert contact_times == pytest.approx(timing[:2], abs=1.1 * DT)


@pytest.mark.parametrize("number", range(6))
def test_finger_stopped_before_its_contact_never_touches(number: int) -> None:
    drive = Drive(latency=0.0)
    draw = drawn(BLOCKS[4], number)
    timing = draw.timing._replace(second=draw.timing.first + 0.015)
    # Held fast: one that is held loosely may be knocked against the other finger.
    clamped = draw.object._replace(clamp_stiffness=1e5, clamp_damping=100.0)
    run = start_run(replace(draw, timing=timing, object=clamped), drive, 0)
    run.advance(round(timing.first * FINGERTIP_RATE) + 1)
    order(run, Command(0.0, 12.0), drive)
    motion = run.advance(2500)
    second_finger = 1 if timing.first_is_index else 0
    assert (motion[:, 1 - second_finger, CONTACT_FORCE] > 0).any()
    assert not (motion[:, second_finger, CONTACT_FORCE] > 0).any()
    assert (motion[:, second_finger, INDENTATION] < 0).all()


@pytest.mark.parametrize("force", [1.0, 4.0, 12.0])
def test_hold_has_the_commanded_force_without_oscillation(force: float) -> None:
    run = start_run(drawn(BLOCKS[2]), Drive(), 20, 1.2)
    order(run, Command(run.nominal_speed, force), Drive())
    motion = run.advance(round(0.9 * FINGERTIP_RATE))
    hold_forces = motion[-round(0.2 * FINGERTIP_RATE) :, :, CONTACT_FORCE]
    # What the hold takes besides is the clamp's.
    assert hold_forces.mean() == pytest.approx(force, abs=0.15)
    assert np.ptp(hold_forces, axis=0).max() < 0.15


@pytest.mark.parametrize("field", ["latency", "acceleration", "force", "speed", "back_damping"])
def test_invalid_drives_are_refused(field: str) -> None:
    with pytest.raises(InputError, match=field):
        Drive(**{field: -1.0})
    with pytest.raises(InputError, match=field):
        Drive(**{field: float("nan")})


def test_commands_are_clipped_to_the_drive() -> None:
    drive = Drive(force=9.0, speed=0.2)
    assert drive.clipped(Command(1.0, 50.0)) == Command(0.2, 9.0)
    assert drive.clipped(Command(-1.0, -5.0)) == Command(-0.2, 0.0)
    with pytest.raises(InputError, match="speed"):
        drive.clipped(Command(float("nan"), 1.0))
