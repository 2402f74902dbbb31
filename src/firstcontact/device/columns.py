"""Meaning of the columns that a board prints or a stream sends: signals and sample counters."""

from __future__ import annotations

import itertools
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Channel,
    ChannelKind,
    DeviceError,
    Finger,
    VibrationSensor,
    finger_name,
)
from firstcontact.core.plausible import is_clock
from firstcontact.core.units import Unit

_log = logging.getLogger("firstcontact.device")

#: Names of a column that counts samples.
COUNTERS = ("counter", "count", "sample", "n", "i", "index", "nr", "#")
#: Names of columns with the time, which are neither signal nor counter.
TIMES = ("t", "time", "ms", "us", "millis", "micros", "timestamp")
#: Numbers at which a counter wraps: 8, 16, 24 or 32 bits.
WRAPS = (2.0**8, 2.0**16, 2.0**24, 2.0**32)
#: Order of columns with the name of a finger, before and after other columns.
_FINGERS = {"index": -1, "thumb": 1}
#: Largest step of a counter between lines. A larger one means damage or a restart.
LEAP = 100_000.0


@dataclass(frozen=True, slots=True)
class Columns:
    """Meaning of the columns in the lines that a board prints.

    ``signals`` are the indices of the vibration columns and ``names`` their names. ``counter`` is
    the index of the column that counts samples, or None. It rises by ``step`` from line to line and
    starts again at one of the numbers ``wraps``. ``width`` is the number of columns.
    """

    names: tuple[str, ...]
    signals: tuple[int, ...]
    counter: int | None
    width: int
    step: float = 1.0
    wraps: tuple[float, ...] = WRAPS


def find_column(word: str, names: Sequence[str]) -> int | None:
    """Return the index of the column with a name or position (1 is the first); None if absent."""
    words = [*names, *(str(k + 1) for k in range(len(names)))]
    return words.index(word) % len(names) if word in words else None


def distinct_names(names: Sequence[str]) -> tuple[str, ...]:
    """Make column names distinct: append the position to names that occur more than once."""
    distinct = [f"{n} {k + 1}" if names.count(n) > 1 else n for k, n in enumerate(names)]
    if len(set(distinct)) < len(distinct):
        distinct = [str(k + 1) for k in range(len(names))]
    return tuple(distinct)


def select_signals(
    device: str, names: Sequence[str], wanted: Sequence[str], default: list[int]
) -> list[int]:
    """Return the indices of the columns that the user wants; ``default`` if ``wanted`` is empty.

    Raises DeviceError, which lists ``names``, unless the result is one or two existing columns.
    """
    matches = [find_column(word, names) for word in wanted]
    places = [k for k in matches if k is not None] if wanted else default
    if None in matches or not 1 <= len(set(places)) == len(places) <= 2:
        missing = next((w for w, k in zip(wanted, matches, strict=True) if k is None), None)
        fault = f"no signal {missing!r}" if missing else f"{len(places)} signals"
        raise DeviceError(
            f"{device} has {fault}: name one or two of {', '.join(names[:16])}, as in "
            f"{device}#{(*names, '1')[0]}"
        )
    return places


def vibration_channels(
    columns: Sequence[Mapping[str, str]], units: Sequence[Unit]
) -> tuple[Channel, ...]:
    """Return the vibration channels of one or two columns, for a layout.

    ``columns`` holds the texts "label", and optionally "finger" and "type" (the sensor), of each
    column. If the fingers are not stated, two columns are those of index finger and thumb.
    """
    by_name = {finger_name(f): f for f in Finger}
    fingers = [by_name.get(column.get("finger", "")) for column in columns]
    if len(set(fingers)) < len(fingers):
        fingers = list(Finger)
    sensors = {str(sensor): sensor for sensor in VibrationSensor}
    return tuple(
        Channel(
            column["label"],
            ChannelKind.VIBRATION,
            finger,
            unit.name,
            unit.scale,
            unit.offset,
            sensor=sensors.get(column.get("type", "").lower()),
        )
        for column, finger, unit in zip(columns, fingers, units, strict=True)
    )


def identify_columns(
    lines: list[tuple[float, ...]], header: tuple[str, ...], wanted: tuple[str, ...], device: str
) -> Columns:
    """Find the signals and the sample counter among the columns of a board's first lines.

    ``header`` are the printed names, or (). ``wanted`` are the names or positions of the signals
    that the user chose, or (). Raises DeviceError if the columns cannot be identified.
    """
    widths = [len(line) for line in lines]
    width = max(set(widths), key=widths.count)
    full_lines = [line for line in lines if len(line) == width]
    if len(full_lines) < 0.8 * len(lines):
        raise DeviceError(
            f"the lines of {device} have from {min(widths)} to {max(widths)} numbers: print the "
            "same number of columns in each line, or set its baud rate (csv:PORT@BAUD)"
        )
    named = len(header) == width
    names = distinct_names(header) if named else tuple(str(k + 1) for k in range(width))
    wanted_places = [k for word in wanted if (k := find_column(word, names)) is not None]
    counter = _find_counter(full_lines, names if named else (), wanted_places)
    if counter is not None and not counts_up(full_lines, counter):
        raise DeviceError(
            f"column {names[counter]!r} of {device} has the name of a counter but does not count "
            "up: rename it, let the board count its samples in it, or name it if it is a signal, "
            f"as in {device}#{names[counter]}"
        )
    table = np.array(full_lines)
    clocks = [k for k in range(width) if is_clock(table[:, k])]
    times = {k for k, n in enumerate(names) if n.lower() in TIMES or k in clocks}
    signals = [k for k in range(width) if k != counter and k not in times]
    places = select_signals(device, names, wanted, signals)
    if left := [names[k] for k in clocks if k not in (*places, counter)]:
        _log.warning(
            "%s: column %s rises steadily, as a clock does, so it is left out: name the columns of "
            "the sensors, as in %s#%s, if this is wrong",
            *(device, ", ".join(left), device, names[places[0]]),
        )
    places.sort(key=lambda k: _FINGERS.get(names[k].lower(), 0))
    chosen = tuple(names[k] for k in places), tuple(places), counter, width
    return (
        Columns(*chosen)
        if counter is None
        else Columns(*chosen, *_step_and_wraps(table[:, counter]))
    )


def _step_and_wraps(counts: NDArray[np.float64]) -> tuple[float, tuple[float, ...]]:
    """Return the usual step of a counter, and the numbers after which it may start again.

    ``counts`` are the counter's numbers in consecutive lines.
    """
    steps = np.diff(counts)
    step = float(np.median(steps[(steps > 0) & (steps <= LEAP)]))
    seen = {step - back for back in steps[steps < 0].tolist()}
    return step, (*WRAPS, *seen)


def _find_counter(
    lines: list[tuple[float, ...]], names: tuple[str, ...], signals: Sequence[int]
) -> int | None:
    """Return the index of the column that counts samples; None without such a column.

    A counter is known by its name or, without names, by its steps of 1. ``signals`` are the indices
    of columns that are signals, so that they cannot be the counter.
    """
    lower = [name.lower() for name in names]
    for k, name in enumerate(lower):
        is_finger = name == "index" and "thumb" in lower and not counts_up(lines, k)
        if name in COUNTERS and k not in signals and not is_finger:
            return k
    for k in range(len(lines[0]) if not names and len(lines[0]) > 1 else 0):
        steps = [b[k] - a[k] for a, b in itertools.pairwise(lines)]
        if k not in signals and steps and steps.count(1.0) > 0.8 * len(steps):
            return k
    return None


def counts_up(lines: list[tuple[float, ...]], column: int) -> bool:
    """Return True if the numbers in a column rise by a small step from most lines to the next."""
    steps = [b[column] - a[column] for a, b in itertools.pairwise(lines)]
    return sum(0 < step <= LEAP for step in steps) >= 0.8 * len(steps)
