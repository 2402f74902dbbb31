"""Movements of the streaming hand in one closing: its speeds, and when they change."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE
from firstcontact.twin._mechanics import INDENTATION
from firstcontact.twin._parameters import FingerParameters
from firstcontact.twin._run import PinchRun

#: Time for a change of the motor's speed, s.
RAMP = 0.06
#: Squeezing ends when the drives have slowed down to this share of the drawn speed.
STALLED = 0.1
#: Longest squeeze of a commanded hand, s after the motor's start.
PATIENCE = 2.0
#: Holding force of each drive, N. It is below the stall force, so that the speed loop damps
#: oscillations.
GRIP = 10.0
#: Distance between skin and object at which the opening hand stops, m.
APART = 5e-3
#: Time for oscillations to decay after the hand has stopped, s.
SETTLE = 0.15
#: Number of samples computed at a time, 5 ms.
PIECE = 25


def pieces(duration: float) -> int:
    """Return the number of pieces of ``PIECE`` samples in ``duration`` s, rounded."""
    return round(duration * FINGERTIP_RATE / PIECE)


def close_hand(run: PinchRun, hold: float) -> Iterator[NDArray[np.float64]]:
    """Yield the motion while the hand closes, squeezes, and holds the object for ``hold`` s."""
    for motion in _squeeze(run, hold):
        yield motion
        if run.released:
            return


def open_hand(run: PinchRun) -> Iterator[NDArray[np.float64]]:
    """Yield the motion while the hand opens, until the fingers have left the object and rest."""
    yield from _ramp(run, -run.nominal_speed)
    while True:
        motion = _piece(run)
        yield motion
        if (motion[-1, :, INDENTATION] < -APART).all():
            break
    yield from _ramp(run, 0.0)
    for _ in range(pieces(SETTLE)):
        yield _piece(run)


def _squeeze(run: PinchRun, hold: float) -> Iterator[NDArray[np.float64]]:
    yield from _ramp(run, run.nominal_speed)
    while not _squeezed(run):
        yield _piece(run)
    # A stalled drive pushes with its gain times the reference speed.
    yield from _ramp(run, GRIP / FingerParameters().speed_gain)
    for _ in range(pieces(hold)):
        yield _piece(run)


def _squeezed(run: PinchRun) -> bool:
    if run.broken_at is not None:
        return True  # the remains never stall the hand
    if run.commanded and run.done > PATIENCE * FINGERTIP_RATE:
        return True
    return all(run.touched) and run.drive_speed <= STALLED * run.nominal_speed


def _ramp(run: PinchRun, speed: float) -> Iterator[NDArray[np.float64]]:
    """Yield the motion while the speed changes smoothly to ``speed``, or a command comes."""
    begin = run.speed
    steps = pieces(RAMP)
    for k in range(steps):
        if run.commanded:
            return
        share = 0.5 - 0.5 * math.cos(math.pi * (k + 1) / steps)
        run.speed = begin + share * (speed - begin)
        yield _piece(run)


def _piece(run: PinchRun) -> NDArray[np.float64]:
    """Return the motion of the next ``PIECE`` samples. Motor noise follows the drive's speed."""
    run.loudness = min(abs(run.drive_speed) / run.nominal_speed, 1.0)
    return run.advance(PIECE)
