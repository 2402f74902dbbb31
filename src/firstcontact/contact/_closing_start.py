"""From where on a detector is to hear a pinch: the one place that decides it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from firstcontact.contact._gate import STEP, STEPS, ClosingGate, Turn
from firstcontact.contact._rest_floor import FEW, rest_floor
from firstcontact.core import Block, Calibration, Dataset, Layout, Pinch
from firstcontact.signal import samples_in


class How(StrEnum):
    """How it is known where a closing starts."""

    #: The pinch says from when on its motor runs.
    LABEL = "label"
    #: The motor is heard above the noise floor that the recording's calibration gives,
    CALIBRATION = "calibration"
    #: or above the rest that the pinches of its session begin with.
    REST = "rest"
    #: Nothing tells of a start: the motor is taken to run from the first sample on.
    FIRST_SAMPLE = "first_sample"


@dataclass(frozen=True, slots=True)
class ClosingStart:
    """The first sample that a detector is given, and how that was decided."""

    sample: int
    how: How


def settling(layout: Layout) -> int:
    """Samples from the start of a motor until it has settled."""
    return STEPS * samples_in(STEP, layout.rate)


def closing_start(pinch: Pinch, floors: Calibration | None = None) -> ClosingStart:
    """Where the closing of a pinch starts: its steady state is measured from there.

    As live, it is 39 ms after the start of the motor, and at the first sample where the
    motor has run already. What the labels know of contacts is not looked at.

    Parameters
    ----------
    pinch
        With its ``motor_start`` or ``calibration``, where known.
    floors
        Found in other pinches of the rig; used where it has neither.
    """
    first = pinch.first_sample
    end = first + len(pinch.data)
    if pinch.motor_start is not None:
        waits = settling(pinch.layout) if pinch.motor_start > first else 0
        return ClosingStart(min(max(first, pinch.motor_start + waits), end), How.LABEL)
    for calibration, how in ((pinch.calibration, How.CALIBRATION), (floors, How.REST)):
        if how is How.CALIBRATION and None in pinch.layout.vibration_fingers:
            break  # recorded from where the gate opened, at rest: no motor is heard in it
        if calibration is not None and _complete(calibration, pinch.layout):
            heard = _heard(pinch, calibration)
            return (
                ClosingStart(first, How.FIRST_SAMPLE) if heard is None else ClosingStart(heard, how)
            )
    return ClosingStart(first, How.FIRST_SAMPLE)


def closing_starts(dataset: Dataset) -> tuple[ClosingStart, ...]:
    """Where the closing of each pinch starts; those of a session share their noise floors."""
    floors = {id(p): found for group in _rigs(dataset.pinches) for p, found in _shared(group)}
    return tuple(closing_start(p, floors.get(id(p))) for p in dataset.pinches)


def cut_closings(dataset: Dataset, starts: Sequence[ClosingStart] | None = None) -> Dataset:
    """The pinches cut to where their closings start: what detectors learn from and judge.

    Parameters
    ----------
    dataset
        The pinches.
    starts
        Of :func:`closing_starts`, where that is known already.

    Returns
    -------
    Dataset
        Samples keep their numbers, and contacts theirs, also those before the start. Each
        ``motor_start`` says that the motor runs from the first sample on: cut again, it
        stays as it is.
    """
    known = closing_starts(dataset) if starts is None else starts
    pairs = zip(dataset.pinches, known, strict=True)
    return replace(dataset, pinches=tuple(_from(p, start.sample) for p, start in pairs))


#: How a closing's start is told of, after "its steady state begins".
WORDS = {
    How.LABEL: "where the label says that the motor has settled",
    How.CALIBRATION: "where the motor is heard above the calibrated noise floor",
    How.REST: "where the motor is heard above the rest before it",
    How.FIRST_SAMPLE: "with the first sample",
}


def describe_starts(ways: Mapping[str, int]) -> str:
    """Where steady states begin, and in how many pinches, in words.

    Parameters
    ----------
    ways
        Of :func:`count_starts`.
    """
    said = [(WORDS[How(how)], n) for how, n in ways.items()]
    parts = [f"{words} ({n:,})" if len(said) > 1 else words for words, n in said]
    return f"steady states begin {', '.join(parts)}"


def count_starts(starts: Sequence[ClosingStart]) -> dict[str, int]:
    """How many closings were told in each way, without those that none was."""
    ways = Counter(start.how for start in starts)
    return {str(how): ways[how] for how in How if ways[how]}


def _from(pinch: Pinch, sample: int) -> Pinch:
    data = pinch.data[sample - pinch.first_sample :]
    return replace(pinch, data=data, first_sample=sample, motor_start=sample)


def _complete(calibration: Calibration, layout: Layout) -> bool:
    return all(calibration.noise(f) is not None for f in layout.vibration_fingers)


def _heard(pinch: Pinch, calibration: Calibration) -> int | None:
    """Where the gate opens for a pinch that begins at rest; None where it does not."""
    gate = ClosingGate(pinch.layout, calibration)
    # 13 steps after one that it knows nothing before: the least that the gate knows rest from.
    at_first = settling(pinch.layout) + samples_in(STEP, pinch.layout.rate)
    gate.update(Block(pinch.data[:at_first], pinch.first_sample))
    if not gate.resting:
        # The motor runs already. A rest that comes later is the grip's, and no beginning.
        return None
    events = gate.update(Block(pinch.data[at_first:], pinch.first_sample + at_first))
    return next((e.sample for e in events if e.turn is Turn.OPENS), None)


def _rigs(pinches: Sequence[Pinch]) -> list[list[Pinch]]:
    """The pinches that nothing is known of, by session; small sessions together."""
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
