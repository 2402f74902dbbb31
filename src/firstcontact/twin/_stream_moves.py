"""What the hand of the stream does in one closing: speeds, and when it turns."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE
from firstcontact.twin._mechanics import INDENTATION
from firstcontact.twin._parameters import FingerParameters
from firstcontact.twin._run import PinchRun

#: The motor gets to another speed in this time, s.
RAMP = 0.06
#: Squeezing is over when the drives have slowed down to this share of their speed.
STALLED = 0.1
#: Of a hand that was commanded it is over at the latest so long after the motor's start, s.
PATIENCE = 2.0
#: Then the hand holds with this force of each drive, N: below its stall force, so that
#: the speed loop damps what swings.
GRIP = 10.0
#: How far apart skin and object are before the opening hand is stopped, m.
APART = 5e-3
#: What still swings when the hand has stopped has died down after this time, s.
SETTLE = 0.15
#: Samples that are made at a time, 5 ms.
PIECE = 25


def pieces(duration: float) -> int:
    """Whole pieces nearest to a time, s."""
    return round(duration * FINGERTIP_RATE / PIECE)


def close_hand(run: PinchRun, hold: float) -> Iterator[NDArray[np.float64]]:
    """Close, squeeze, and hold for ``hold`` s; less where the hand is released.

    A command takes the place of the drawn speed and of the hold's force.
    """
    for motion in _squeeze(run, hold):
        yield motion
        if run.released:
            return


def open_hand(run: PinchRun) -> Iterator[NDArray[np.float64]]:
    """Open until the object is let go, and come to rest."""
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
    # A drive that stands pushes with its gain times the speed that it is to follow.
    yield from _ramp(run, GRIP / FingerParameters().speed_gain)
    for _ in range(pieces(hold)):
        yield _piece(run)


def _squeezed(run: PinchRun) -> bool:
    if run.broken_at is not None:
        return True  # what is left never stalls the hand
    if run.commanded and run.done > PATIENCE * FINGERTIP_RATE:
        return True
    return all(run.touched) and run.drive_speed <= STALLED * run.nominal_speed


def _ramp(run: PinchRun, speed: float) -> Iterator[NDArray[np.float64]]:
    """Bring the hand to another speed without a jerk, unless it is commanded."""
    begin = run.speed
    steps = pieces(RAMP)
    for k in range(steps):
        if run.commanded:
            return
        share = 0.5 - 0.5 * math.cos(math.pi * (k + 1) / steps)
        run.speed = begin + share * (speed - begin)
        yield _piece(run)


def _piece(run: PinchRun) -> NDArray[np.float64]:
    """The next piece; a motor that stalls or stands is not heard."""
    run.loudness = min(abs(run.drive_speed) / run.nominal_speed, 1.0)
    return run.advance(PIECE)
