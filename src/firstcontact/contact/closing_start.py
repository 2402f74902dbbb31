"""Search for the sample at which the hand starts to close, from which detectors are applied."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from firstcontact.chain import Chain, EventKind, Image, build_image
from firstcontact.chain.image import GATE_STEP
from firstcontact.chain.touch import touch_constants
from firstcontact.core import Block, Calibration, Dataset, Layout, Pinch, VibrationCalibration
from firstcontact.recording import Recording
from firstcontact.recording.dataset import cut
from firstcontact.signal import resample_dataset, samples_in

#: Number of steps of the gate over which it judges rest and the settling of the motor.
STEPS = 13
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


def rest_floor(pinches: Sequence[Pinch]) -> Calibration | None:
    """Return each finger's noise at rest, from pinches in which the motor starts after a rest.

    It is infinite for a finger whose motor starts are audible in too few pinches. Return None if
    that holds for all fingers.
    """
    running = RUNNING_OF_FEW if len(pinches) < FEW else touch_constants().running
    starts = [start for p in pinches if (start := _rest_and_motor(p, running))]
    if not starts:
        return None
    rest_levels, motor = np.array(starts).swapaxes(0, 1)
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


def _rest_and_motor(
    pinch: Pinch, running: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """Return the RMS at rest and that with a running motor, V, shape (fingers,) each.

    A motor counts as running if the RMS exceeds that at rest by the factor ``running``. The second
    RMS is 0 for fingers without an audible motor. Return None if the pinch is too short.
    """
    samples = samples_in(GATE_STEP, pinch.layout.rate)
    if not samples:  # the rate is too low
        return None
    volts = pinch.vibration()
    steps = len(volts) // samples
    if steps < 3 * STEPS or not np.isfinite(volts).all():
        return None
    power = step_powers(volts[: steps * samples].reshape(steps, samples, -1))
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
    return lasting[0], motor


def step_powers(piezo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the power of each step of samples, in all runs of 13 steps, V².

    ``piezo`` has the shape (steps, samples, fingers). The power is that around the run's median
    level. The shape of the result is (runs, fingers, 13).
    """
    samples = piezo.shape[1]
    total = sliding_window_view(piezo.sum(axis=1), STEPS, axis=0)
    squares = sliding_window_view((piezo**2).sum(axis=1), STEPS, axis=0)
    mean = median(total)[:, :, None] / samples
    power: NDArray[np.float64] = (squares - 2 * mean * total) / samples + mean**2
    return power


def median(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median along the last axis, whose length must be odd. Faster than numpy.median."""
    middle = x.shape[-1] // 2
    out: NDArray[np.float64] = np.partition(x, middle)[..., middle]
    return out


class StartMethod(StrEnum):
    """Method by which the start of a closing was found."""

    #: The label holds the start of the motor.
    LABEL = "label"
    #: The motor is audible above the noise floor of the recording's calibration.
    CALIBRATION = "calibration"
    #: The motor is audible above the rest at the start of the session's pinches.
    REST = "rest"
    #: The start is unknown: the motor is assumed to run from the first sample on.
    FIRST_SAMPLE = "first_sample"


@dataclass(frozen=True, slots=True)
class DetectionStart:
    """Sample from which a detector is applied to a pinch, and the method that found it."""

    sample: int
    how: StartMethod


def settling(layout: Layout) -> int:
    """Return the number of samples from the start of a motor until it runs steadily."""
    return STEPS * samples_in(GATE_STEP, layout.rate)


def closing_start(pinch: Pinch, floors: Calibration | None = None) -> DetectionStart:
    """Return the sample from which the motor runs steadily, and the method that found it.

    ``floors`` are the noise floors of the session's pinches, used if the pinch states none.
    """
    first = pinch.first_sample
    end = first + len(pinch.data)
    if pinch.motor_start is not None:
        settles = settling(pinch.layout) if pinch.motor_start > first else 0
        sample = min(max(first, pinch.motor_start + settles), end)
        return DetectionStart(sample, StartMethod.LABEL)
    sources = [(pinch.calibration, StartMethod.CALIBRATION), (floors, StartMethod.REST)]
    if None in pinch.layout.vibration_fingers:
        sources = []  # a sensor that a person moves: there is no motor to hear
    for calibration, how in sources:
        if calibration is not None and _has_all_floors(calibration, pinch.layout):
            start = _audible_start(pinch, calibration)
            if start is not None:
                return DetectionStart(start, how)
            break
    return DetectionStart(first, StartMethod.FIRST_SAMPLE)


def closing_starts(dataset: Dataset) -> tuple[DetectionStart, ...]:
    """Return for each pinch the sample from which the motor runs steadily, and the method."""
    floors = {
        id(p): floor for group in _session_groups(dataset.pinches) for p, floor in _shared(group)
    }
    return tuple(closing_start(p, floors.get(id(p))) for p in dataset.pinches)


@dataclass(frozen=True, slots=True, order=True)
class RecordedClosing:
    """Closing of a recorded pinch: epoch, first sample for the detector, and end."""

    epoch: int
    start: int
    #: First sample after the pinch.
    end: int


def recorded_closings(recording: Recording, rate: float) -> tuple[RecordedClosing, ...]:
    """Return the closings of all complete pinches of a recording, in time order.

    Their samples are counted at ``rate``, Hz.
    """
    pairs = [(mark.epoch, cut(recording, mark)) for mark in recording.pinches]
    dataset = resample_dataset(Dataset(tuple(p for _, p in pairs if p is not None)), rate)
    return tuple(
        sorted(
            RecordedClosing(epoch, start.sample, pinch.first_sample + len(pinch.data))
            for epoch, start, pinch in zip(
                (epoch for epoch, pinch in pairs if pinch is not None),
                closing_starts(dataset),
                dataset.pinches,
                strict=True,
            )
        )
    )


def cut_closings(dataset: Dataset, starts: Sequence[DetectionStart] | None = None) -> Dataset:
    """Return the pinches without the samples before ``starts``, to train and score detectors."""
    all_starts = closing_starts(dataset) if starts is None else starts
    pairs = zip(dataset.pinches, all_starts, strict=True)
    return replace(dataset, pinches=tuple(_cut(p, start.sample) for p, start in pairs))


#: Description of each source, after "steady states begin".
WORDS = {
    StartMethod.LABEL: "where the label says that the motor has settled",
    StartMethod.CALIBRATION: "where the motor is heard above the calibrated noise floor",
    StartMethod.REST: "where the motor is heard above the rest before it",
    StartMethod.FIRST_SAMPLE: "with the first sample",
}


def describe_starts(counts: Mapping[str, int]) -> str:
    """Return a text on the methods that found the starts of closings, with their counts."""
    descriptions = [(WORDS[StartMethod(how)], n) for how, n in counts.items()]
    parts = [f"{words} ({n:,})" if len(descriptions) > 1 else words for words, n in descriptions]
    return f"steady states begin {', '.join(parts)}"


def count_starts(starts: Sequence[DetectionStart]) -> dict[str, int]:
    """Return the number of closings per method that found their start. Keys are method names."""
    counts = Counter(start.how for start in starts)
    return {str(how): counts[how] for how in StartMethod if counts[how]}


def _cut(pinch: Pinch, sample: int) -> Pinch:
    data = pinch.data[sample - pinch.first_sample :]
    cut = replace(pinch, data=data, first_sample=sample, motor_start=sample, truth=())
    # A contact before the cut stays the true one, which no detector can find.
    object.__setattr__(cut, "truth", pinch.truth)
    return cut


def _has_all_floors(calibration: Calibration, layout: Layout) -> bool:
    return all(calibration.noise(f) is not None for f in layout.vibration_fingers)


def _audible_start(pinch: Pinch, calibration: Calibration) -> int | None:
    """Return the number of the sample at which the motor becomes audible after a rest.

    Return None if the pinch does not begin at rest, or if the motor stays inaudible.
    """
    gate = Chain(_gate_image(pinch.layout.rate), pinch.layout, calibration)
    # The gate needs 13 steps to recognise rest, after a first one of unknown state.
    lead = settling(pinch.layout) + samples_in(GATE_STEP, pinch.layout.rate)
    gate.take(Block(pinch.data[:lead], pinch.first_sample))
    if not gate.is_resting:
        # The motor runs already. Later rest belongs to the grip and starts no closing.
        return None
    events = gate.take(Block(pinch.data[lead:], pinch.first_sample + lead))
    return next((e.sample for e in events if e.kind == EventKind.CLOSING_BEGAN), None)


@lru_cache(maxsize=8)
def _gate_image(rate: float) -> Image:
    """Return the constants of a C chain that detects closings of the hand, but not contacts."""
    return build_image(rate)


def _session_groups(pinches: Sequence[Pinch]) -> list[list[Pinch]]:
    """Return the pinches without a known motor start, grouped by session.

    Sessions with fewer than ``FEW`` such pinches are joined in one group, the last one.
    """
    sessions: dict[str, list[Pinch]] = {}
    for pinch in pinches:
        if pinch.motor_start is None and pinch.layout.vibration_fingers:
            sessions.setdefault(pinch.label.session, []).append(pinch)
    large = [group for group in sessions.values() if len(group) >= FEW]
    small = [pinch for group in sessions.values() if len(group) < FEW for pinch in group]
    return [*large, small] if small else large


def _shared(group: Sequence[Pinch]) -> list[tuple[Pinch, Calibration]]:
    floors = rest_floor(group)
    return [] if floors is None else [(pinch, floors) for pinch in group]
