"""Noise floor of a hand at rest, estimated from pinches that begin before its motor starts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.chain import GATE_STEP
from firstcontact.core import Calibration, Pinch, VibrationCalibration
from firstcontact.signal import samples_in

#: Number of steps of the gate over which it judges rest and the settling of the motor.
STEPS = 13
#: The motor runs if the RMS of a piezo exceeds its noise floor by this factor.
RUNNING = 1.4
#: Least loudness of the contact relative to the motor before it. On the twin the factor is 12 or
#: more. If the first rise is not the motor but the contact, later signals reach a factor of 2 at
#: most.
LOUDER = 3.0
#: Least share of pinches with an audible start of the motor. If pinches begin at rest, 80 % and
#: more have one. If the motor runs from the first sample, its changing loudness looks like a start
#: in up to 15 %.
MOST = 0.5
#: Number of pinches below which chance could decide.
FEW = 8
#: Least loudness of the motor relative to rest if there are fewer than FEW pinches.
RUNNING_OF_FEW = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class _Start:
    """Levels at the start of a pinch, at rest and with the motor, shape (fingers,)."""

    quiet: NDArray[np.float64]  # RMS of the first 39 ms, V
    motor: NDArray[np.float64]  # of the motor, V; 0 without an audible motor


def rest_floor(pinches: Sequence[Pinch]) -> Calibration | None:
    """Return the noise floors of the fingers if these pinches begin at rest, else None."""
    few = len(pinches) < FEW
    starts = [start for p in pinches if (start := _start(p, RUNNING_OF_FEW if few else RUNNING))]
    if not starts:
        return None
    rest_levels, motor = (
        np.array([getattr(s, name) for s in starts]) for name in ("quiet", "motor")
    )
    heard = motor > 0
    hearing = heard.sum(axis=0) >= MOST * len(pinches)
    if not hearing.any():
        return None
    floors = []
    for column, finger in enumerate(pinches[0].layout.vibration_fingers):
        has_start = heard[:, column]
        # Generated data may have exact silence, and no multiple of 0 exceeds it.
        floor = (
            np.maximum(rest_levels[has_start, column], 1e-3 * motor[has_start, column])
            if hearing[column]
            else None
        )
        noise = float("inf") if floor is None else float(np.median(floor))
        floors.append(VibrationCalibration(finger, noise))
    return Calibration(tuple(floors))


def _start(pinch: Pinch, running: float) -> _Start | None:
    """Return the levels at the start of a pinch; None if the pinch is unusable or too short."""
    samples = samples_in(GATE_STEP, pinch.layout.rate)
    if not samples:  # the rate is too low
        return None
    volts = pinch.vibration()
    steps = len(volts) // samples
    if steps < 3 * STEPS or not np.isfinite(volts).all():
        return None
    sums = step_sums(volts[: steps * samples].reshape(steps, samples, -1))
    power = step_powers(sums, samples)
    lasting = np.sqrt(np.maximum(median(power), 0.0))  # median RMS of 13 steps, from each step on
    single = np.concatenate([power[0].T, power[1:, :, -1]])  # power of each single step
    single = np.sqrt(np.maximum(single, 0.0))
    motor = np.zeros(lasting.shape[1])
    for f in range(len(motor)):
        loud = np.flatnonzero(lasting[:, f] > running * lasting[0, f])
        if not len(loud):
            continue
        begin = int(loud[0]) + STEPS // 2
        settled = begin + STEPS
        stays = lasting[begin : settled + 1, f]
        later = single[settled:, f]
        if len(stays) <= STEPS or not len(later):
            continue
        of_motor = single[begin - 1 : settled, f].max()
        if stays.min() > running * lasting[0, f] and later.max() > LOUDER * of_motor:
            motor[f] = stays[0]
    return _Start(lasting[0], motor)


def step_sums(piezo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sum and the sum of squares of each step, shape (steps, 2, fingers)."""
    sums = np.empty((len(piezo), 2, piezo.shape[2]))
    sums[:, 0] = piezo.sum(axis=1)
    sums[:, 1] = (piezo**2).sum(axis=1)
    return sums


def step_powers(sums: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    """Return the power of each step in every run of 13 steps, relative to the run's level."""
    sums = np.ascontiguousarray(sums)
    step, kind, finger = sums.strides
    shape = (2, len(sums) - STEPS + 1, sums.shape[2], STEPS)
    # Faster than numpy's sliding_window_view, which takes longer than the rest of the function.
    total, squares = np.ndarray(shape, sums.dtype, sums, 0, (kind, step, finger, step))
    mean = median(total)[:, :, None] / samples
    power: NDArray[np.float64] = (squares - 2 * mean * total) / samples + mean**2
    return power


def median(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median along the last axis of odd length, 10 times faster than numpy.median."""
    middle = x.shape[-1] // 2
    ordered = x.copy()
    ordered.partition(middle)
    out: NDArray[np.float64] = ordered[..., middle]
    return out
