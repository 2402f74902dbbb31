"""Start of a closing: the first sample of a pinch that a detector gets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import lru_cache

from firstcontact.chain import GATE_STEP, Chain, EventKind, Image, build_image
from firstcontact.contact._rest_floor import FEW, STEPS, rest_floor
from firstcontact.core import Block, Calibration, Dataset, Layout, Pinch
from firstcontact.signal import samples_in


class How(StrEnum):
    """Method that found the start of a closing."""

    #: The label holds the start of the motor.
    LABEL = "label"
    #: The motor is audible above the noise floor of the recording's calibration.
    CALIBRATION = "calibration"
    #: The motor is audible above the rest at the start of the session's pinches.
    REST = "rest"
    #: The start is unknown: the motor is assumed to run from the first sample on.
    FIRST_SAMPLE = "first_sample"


@dataclass(frozen=True, slots=True)
class ClosingStart:
    """First sample for the detector, and the method that found it."""

    sample: int
    how: How


def settling(layout: Layout) -> int:
    """Return the number of samples that a motor needs to settle after its start."""
    return STEPS * samples_in(GATE_STEP, layout.rate)


def closing_start(pinch: Pinch, floors: Calibration | None = None) -> ClosingStart:
    """Return the start of a pinch's closing, where the steady state begins.

    The closing starts 39 ms after the motor, as in a live session. If the motor runs from the first
    sample on, or its start is unknown, the closing starts with the first sample. Labels of contacts
    are not used.
    """
    first = pinch.first_sample
    end = first + len(pinch.data)
    if pinch.motor_start is not None:
        settling_samples = settling(pinch.layout) if pinch.motor_start > first else 0
        return ClosingStart(min(max(first, pinch.motor_start + settling_samples), end), How.LABEL)
    for calibration, how in ((pinch.calibration, How.CALIBRATION), (floors, How.REST)):
        if how is How.CALIBRATION and None in pinch.layout.vibration_fingers:
            break  # a sensor that a person moves: there is no motor to hear
        if calibration is not None and _has_all_floors(calibration, pinch.layout):
            audible_start = _audible_start(pinch, calibration)
            return (
                ClosingStart(first, How.FIRST_SAMPLE)
                if audible_start is None
                else ClosingStart(audible_start, how)
            )
    return ClosingStart(first, How.FIRST_SAMPLE)


def closing_starts(dataset: Dataset) -> tuple[ClosingStart, ...]:
    """Return the start of each pinch's closing.

    If a pinch has neither a known start of the motor nor noise floors, the floors are estimated
    from the pinches of its session.
    """
    floors = {id(p): floor for group in _rigs(dataset.pinches) for p, floor in _shared(group)}
    return tuple(closing_start(p, floors.get(id(p))) for p in dataset.pinches)


def cut_closings(dataset: Dataset, starts: Sequence[ClosingStart] | None = None) -> Dataset:
    """Cut the pinches to the starts of their closings, for training and scoring detectors."""
    all_starts = closing_starts(dataset) if starts is None else starts
    pairs = zip(dataset.pinches, all_starts, strict=True)
    return replace(dataset, pinches=tuple(_cut(p, start.sample) for p, start in pairs))


#: Description of each source, after "steady states begin".
WORDS = {
    How.LABEL: "where the label says that the motor has settled",
    How.CALIBRATION: "where the motor is heard above the calibrated noise floor",
    How.REST: "where the motor is heard above the rest before it",
    How.FIRST_SAMPLE: "with the first sample",
}


def describe_starts(counts: Mapping[str, int]) -> str:
    """Return a text that states where the steady states begin, and in how many pinches."""
    descriptions = [(WORDS[How(how)], n) for how, n in counts.items()]
    parts = [f"{words} ({n:,})" if len(descriptions) > 1 else words for words, n in descriptions]
    return f"steady states begin {', '.join(parts)}"


def count_starts(starts: Sequence[ClosingStart]) -> dict[str, int]:
    """Return the number of closings for each method that found one or more."""
    counts = Counter(start.how for start in starts)
    return {str(how): counts[how] for how in How if counts[how]}


def _cut(pinch: Pinch, sample: int) -> Pinch:
    data = pinch.data[sample - pinch.first_sample :]
    return replace(pinch, data=data, first_sample=sample, motor_start=sample)


def _has_all_floors(calibration: Calibration, layout: Layout) -> bool:
    return all(calibration.noise(f) is not None for f in layout.vibration_fingers)


def _audible_start(pinch: Pinch, calibration: Calibration) -> int | None:
    """Return the sample at which the gate opens if the pinch begins at rest, else None."""
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
    """Return the image of a chain without a detector."""
    return build_image(rate)


def _rigs(pinches: Sequence[Pinch]) -> list[list[Pinch]]:
    """Return the pinches whose motor start is unknown, in one group per session."""
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
