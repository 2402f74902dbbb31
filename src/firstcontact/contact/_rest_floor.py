"""The noise floor of a hand at rest, found in pinches that begin before its motor does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact._gate import RUNNING, STEP, STEPS, median, step_powers, step_sums
from firstcontact.core import Calibration, Pinch, VibrationCalibration
from firstcontact.signal import samples_in

#: What follows the start of a motor, the contact, is so many times louder than all of it. On
#: the twin 12 times and more; what follows a contact is 2 times as loud at most.
LOUDER = 3.0
#: Share of the pinches in which a start must be heard. With the motor running from the first
#: sample, its wandering loudness makes up to 15 % look like one; from rest, 80 % and more do.
MOST = 0.5
#: Fewer pinches than this are too few to outvote chance ...
FEW = 8
#: ... so a start counts there only where the motor is so many times louder than rest.
RUNNING_OF_FEW = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class _Start:
    """How a pinch begins, each of shape (fingers,)."""

    rest: NDArray[np.float64]  # RMS of the first 39 ms, V
    motor: NDArray[np.float64]  # of what rises above it, V; 0 where nothing like a motor does


def rest_floor(pinches: Sequence[Pinch]) -> Calibration | None:
    """Noise floors of the fingers, where these pinches begin at rest; else None.

    Rest is what the beginnings have in common where most pinches go on like this: their
    first 39 ms are quiet, the signal then rises above that and stays there for 80 ms (a
    motor, whose loudness may wander but does not fade), and something much louder follows
    (the contact). A contact after rest, with no motor heard between them, does not look
    so: nothing three times as loud comes after it. Labels are not looked at.

    Parameters
    ----------
    pinches
        Of one rig: their floor is taken as the same. They share a layout.

    Returns
    -------
    Calibration or None
        A finger on which no motor is heard has an infinite floor: it decides nothing.
    """
    few = len(pinches) < FEW
    starts = [start for p in pinches if (start := _start(p, RUNNING_OF_FEW if few else RUNNING))]
    if not starts:
        return None
    rest, motor = (np.array([getattr(s, name) for s in starts]) for name in ("rest", "motor"))
    heard = motor > 0
    hearing = heard.sum(axis=0) >= MOST * len(pinches)
    if not hearing.any():
        return None
    floors = []
    for column, finger in enumerate(pinches[0].layout.vibration_fingers):
        its = heard[:, column]
        # Rest may be exact silence in numbers that nobody measured: of that no multiple is more.
        floor = (
            np.maximum(rest[its, column], 1e-3 * motor[its, column]) if hearing[column] else None
        )
        noise = float("inf") if floor is None else float(np.median(floor))
        floors.append(VibrationCalibration(finger, noise))
    return Calibration(tuple(floors))


def _start(pinch: Pinch, running: float) -> _Start | None:
    """How a pinch begins; None where it is too short to tell."""
    samples = samples_in(STEP, pinch.layout.rate)
    volts = pinch.vibration()
    steps = len(volts) // samples
    if steps < 3 * STEPS or not np.isfinite(volts).all():
        return None
    sums = step_sums(volts[: steps * samples].reshape(steps, samples, -1))
    power = step_powers(sums, samples)
    lasting = np.sqrt(np.maximum(median(power), 0.0))  # RMS of most of 13 steps, from each on
    single = np.concatenate([power[0].T, power[1:, :, -1]])  # of each step by itself
    single = np.sqrt(np.maximum(single, 0.0))
    motor = np.zeros(lasting.shape[1])
    for f in range(len(motor)):
        loud = np.flatnonzero(lasting[:, f] > running * lasting[0, f])
        if not len(loud):
            continue
        begin = int(loud[0]) + STEPS // 2
        settled = begin + STEPS
        stays = lasting[begin : settled + 1, f]
        after = single[settled:, f]
        if len(stays) <= STEPS or not len(after):
            continue
        of_motor = single[begin - 1 : settled, f].max()
        if stays.min() > running * lasting[0, f] and after.max() > LOUDER * of_motor:
            motor[f] = stays[0]
    return _Start(lasting[0], motor)
