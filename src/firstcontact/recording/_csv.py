"""Importer of a long CSV file with one row per sample. Each row repeats the labels of its pinch.

The page docs/how-to/import-recordings.md lists the columns. Exported files also have a column
``firstcontact_layout`` in the first row of each pinch: the names and the meaning of the signals,
which replaces all settings but ``source``.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, FileError, VibrationSensor
from firstcontact.core.layout import TAXELS
from firstcontact.core.text import parse_float, parse_int
from firstcontact.recording._arrays import from_signals
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import PINCH_COLUMNS, note_unknown
from firstcontact.recording.settings import (
    HIGHEST_RATE,
    LAYOUT,
    LOWEST_RATE,
    SETTINGS,
    check_rate,
    check_samples,
    check_vibration,
    find_sensor,
    given_rate,
    joined,
    read_layout,
)
from firstcontact.recording.table import Table, read_columns
from firstcontact.recording.untrusted import quote

Bounds = Sequence[tuple[int, int]]

#: Columns of the signals besides the vibration.
_OTHERS = {
    "force": [f"force_{f}_{k}" for f in ("index", "thumb") for k in range(TAXELS)],
    "strip": ["strip_index", "strip_thumb"],
}
#: Sensors without a usual unit, with an example of one.
_UNSTATED: dict[str, str] = {VibrationSensor.ACCELEROMETER: "g", VibrationSensor.HYDROPHONE: "Pa"}
_NOT_SIGNALS = {"pinch", "time_s", *SETTINGS, LAYOUT}
#: Largest relative difference between two statements of the rate.
_RATES_AGREE = 0.01
#: Largest relative uncertainty of a rate that rounded times give.
_RATE_KNOWN = 1e-3
#: Smallest distance from a line, in steps, of times with a lost or doubled sample.
_ASTRAY = 0.75
#: Largest distance of a step from a multiple of the rounding, as a share of it.
_WHOLE = 0.25
#: Smallest such distance of the mean step, unless it is a share of the rounding.
_EXACT = 0.05


def import_csv(path: Path, rate: float | None = None) -> Dataset:
    """Import pinches from a CSV file with one row per sample. ``rate`` is the rate in Hz, if given.

    Raises FileError, which names the cell, if the file cannot be used.
    """
    table = read_columns(path, "pinch")
    if "pinch" not in table:
        raise FileError(
            f"{path} has no column 'pinch': add it, with the number or name of each row's pinch "
            "(one row is one sample)"
        )
    bounds = _pinch_rows(table)
    rows = [(0, bounds[-1][1])]
    given = {name: _value_per_pinch(table, name, rows)[0] for name in SETTINGS if name in table}
    given["sample_rate_hz"] = str(_find_rate(table, bounds, given.get("sample_rate_hz"), rate))
    if LAYOUT in table:
        texts = set(table[LAYOUT]) - {""}
        if len(texts) != 1:
            raise FileError(
                f"{path}: the column '{LAYOUT}' has {len(texts)} layouts, not one: export the "
                "recordings again"
            )
        given[LAYOUT] = texts.pop()
        layout = read_layout(str(path), given[LAYOUT])
        names = {name: [name] for name in map(str.strip, layout.column_names)}
        signals = {name: _column_samples(table, name) for name in names}
    else:
        remedy = "column 'piezo_index': add it (one row is one sample)"
        sensor = find_sensor(str(path), table, remedy, "_index")
        fingers = _vibration_columns(table, sensor)
        names = {sensor: [name for finger in fingers for name in finger], **_other_columns(table)}
        for kind in {sensor, "force"}.intersection(names):
            given[f"{kind}_unit"] = _find_unit(table, kind, names[kind], given.get(f"{kind}_unit"))
        signals = {
            kind: joined(
                [_column_samples(table, name, kind == sensor)[:, None] for name in columns]
            )
            for kind, columns in names.items()
        }
        signals[sensor] = signals[sensor].reshape(len(table["pinch"]), len(fingers), -1)
    labels = {name: table[name] for name in PINCH_COLUMNS if name in table}
    for name in labels:
        _value_per_pinch(table, name, bounds)
    of_rows = Table(path, labels, table.numbers, units=table.units)
    of_pinches = of_rows.of_rows([start for start, _ in bounds])
    unknown = set(table) - _NOT_SIGNALS - {name for columns in names.values() for name in columns}
    return from_signals(of_pinches, signals, bounds, given, note_unknown(table, unknown))


def _vibration_columns(table: Table, sensor: VibrationSensor) -> list[list[str]]:
    """Return the names of the columns of each vibration sensor, one list per sensor.

    The file has one sensor that belongs to no finger, or a sensor on one finger or on both.
    """

    def columns_named(named: str) -> list[str]:
        axes = (f"{named}_{axis}" for axis in "xyz")
        return [named] if named in table else [name for name in axes if name in table]

    fingers = [columns_named(sensor)]
    if not fingers[0]:
        fingers = [columns_named(f"{sensor}_index"), columns_named(f"{sensor}_thumb")]
    present = [names for names in fingers if names]
    if len({len(names) for names in present}) > 1:
        raise FileError(
            f"{table.path}: the {sensor} of one finger has more axes than the other's: give both "
            "the same columns"
        )
    return present


def _other_columns(table: Table) -> dict[str, list[str]]:
    """Return the column names of force and contact strips, by kind of signal.

    A kind without columns is absent. Raises FileError if only some columns of a kind exist.
    """
    for names in _OTHERS.values():
        missing = [name for name in names if name not in table]
        if 0 < len(missing) < len(names):
            raise FileError(
                f"{table.path} has no column '{missing[0]}': give all of {names[0]} to "
                f"{names[-1]}, or none"
            )
    return {kind: names for kind, names in _OTHERS.items() if names[0] in table}


def _find_unit(table: Table, kind: str, names: Sequence[str], stated: str | None) -> str:
    """Return the unit of the signals of one ``kind``, which have the column names ``names``.

    It is ``stated``, or stands in a column's name, as in "piezo_index (mV)". Raises FileError if
    there are two units, or no unit for a kind of sensor that needs one.
    """
    given = [stated, *map(table.units.get, names)]
    units = [*dict.fromkeys(unit for unit in given if unit is not None)]
    if len(units) > 1:
        raise FileError(
            f"{table.path}: '{names[0]}' has the units {' and '.join(units)}: give one unit"
        )
    if not units and kind in _UNSTATED:
        raise FileError(
            f"{table.path} does not state the unit of '{names[0]}': write it after the name, such "
            f"as '{names[0]} ({_UNSTATED[kind]})', or add a column '{kind}_unit'"
        )
    return units[0] if units else "V"


def _column_samples(table: Table, name: str, is_vibration: bool = False) -> NDArray[Any]:
    """Return the samples in the column ``name``: integers if all are whole numbers, else floats."""
    if name not in table:
        raise FileError(f"{table.path} has no column {quote(name)}: add it, or export it again")
    values = np.array(table.parsed(name, parse_float))
    with suppress(ValueError, OverflowError):  # fractions, and integers beyond 64 bits
        values = np.array([parse_int(cell) for cell in table[name]], np.int64)
    return (check_vibration if is_vibration else check_samples)(f"{table.path}: {name}", values)


def _pinch_rows(table: Table) -> Bounds:
    """Return (first row, row after the last one) of each pinch."""
    bounds = []
    seen = set()
    start = 0
    for name, rows in groupby(table["pinch"]):
        if name in seen:
            reason = "which has other rows before"
            raise table.refusal("pinch", start, reason, "put the rows of a pinch together")
        seen.add(name)
        stop = start + sum(1 for _ in rows)
        bounds.append((start, stop))
        start = stop
    return bounds


def _value_per_pinch(table: Table, name: str, bounds: Bounds) -> list[str]:
    """Return the value of a column in each pinch. Raise FileError if a pinch has two values."""
    cells = table[name]
    for start, stop in bounds:
        for row in range(start, stop):
            if cells[row] != cells[start]:
                reason = f"but {quote(cells[start])} in {table.place(start)}"
                raise table.refusal(name, row, reason, "give one value in all rows")
    return [cells[start] for start, _ in bounds]


def _find_rate(table: Table, bounds: Bounds, written: str | None, option: float | None) -> float:
    """Return the sampling rate, Hz.

    ``option`` is the rate that the user gave, and ``written`` the cell "sample_rate_hz". The column
    "time_s" gives a third rate. Raises FileError if two of these differ or all are missing.
    """
    rates: list[tuple[str, float]] = []
    if option is not None:
        rates.append(("--rate", given_rate(option)))
    if written is not None:
        rates.append(("sample_rate_hz", check_rate(f"{table.path}: sample_rate_hz", written)))
    # Relative uncertainty of the times' rate.
    uncertain = 0.0
    if "time_s" in table:
        times = np.array(table.parsed("time_s", parse_float))
        for start, stop in bounds:
            measured, error = _rate_from_times(table, times, start, stop)
            rates.append(("time_s", measured))
            uncertain = max(uncertain, error)
    if not rates:
        raise FileError(
            f"{table.path} does not state its rate: add a column 'time_s' or 'sample_rate_hz', or "
            "give --rate"
        )
    first, rate = rates[0]
    for name, other in rates[1:]:
        if abs(other - rate) > max(_RATES_AGREE, uncertain) * rate:
            raise FileError(
                f"{table.path}: '{name}' states {other:g} Hz, but '{first}' states {rate:g} Hz: "
                "correct one of them"
            )
    if first != "time_s" or not uncertain:
        return rate
    if uncertain > _RATE_KNOWN:
        raise FileError(
            f"{table.path}: 'time_s' is rounded, so that its rate is only known to "
            f"{uncertain:.2%}: give --rate"
        )
    # Rates are round numbers more often than rounded times make them.
    simple = (float(f"{rate:.{digits}g}") for digits in range(1, 18))
    return next(r for r in simple if abs(r - rate) <= uncertain * rate)


def _rate_from_times(
    table: Table, times: NDArray[np.float64], start: int, stop: int
) -> tuple[float, float]:
    """Return the mean sampling rate of one pinch, Hz, and the rate's relative error from rounding.

    The pinch has the rows ``start`` to ``stop``. Raises FileError if the times do not rise evenly.
    """
    moments = times[start:stop]
    steps = np.diff(moments)
    if not len(steps):
        raise FileError(
            f"{table.path}: the pinch of {table.place(start)} has only one sample: remove it"
        )
    step = float(moments[-1] - moments[0]) / len(steps)
    rounding = float(np.ptp(steps))
    jumps = np.flatnonzero(~((steps > 0.5 * step) & (steps < 1.5 * step)))
    slope = float(np.polyfit(np.arange(len(moments)), moments, 1)[0])
    wander = float(np.ptp(moments - slope * np.arange(len(moments))))
    if not wander < _ASTRAY * step and len(jumps):
        # Rounded times take steps of two neighbouring multiples of the rounding.
        levels = steps / rounding if rounding > 0 else steps
        share = step / (rounding or 1.0)
        step = slope
        is_rounded = (
            np.abs(levels - levels.round()).max() < _WHOLE
            and abs(float(np.sum(levels - levels.round()))) < 1
            and step > 0
            and wander < 1.5 * rounding
            # A lost sample between exact times also makes a step of two multiples.
            and abs(share - max(1, round(share))) > _EXACT
        )
        if not is_rounded:
            row = start + int(jumps[0]) + 1
            reason = f"a jump from {times[row - 1]:g} (samples are missing or out of order)"
            raise table.refusal("time_s", row, reason, "leave the pinch out")
    error = rounding / (step * len(steps))
    if not len(jumps) and error > _RATE_KNOWN:  # jitter
        error = 0.0
    return _checked_rate(table, 1 / step), error


def _checked_rate(table: Table, rate: float) -> float:
    """Return ``rate``, Hz. If it is impossible, raise FileError with a unit that would fit."""
    origin = f"{table.path}: the rate of time_s"
    for unit, factor in (("ms", 1e3), ("us", 1e6)):
        if not LOWEST_RATE <= rate <= HIGHEST_RATE and 1e3 <= rate * factor <= 1e5:
            raise FileError(
                f"{origin} is {rate:g} Hz: if its times are in {unit}, name the column "
                f"'time_{unit}'"
            )
    return check_rate(origin, rate)


CSV = Importer("csv", "a .csv file", import_csv, suffixes=(".csv",), options=("rate",))
