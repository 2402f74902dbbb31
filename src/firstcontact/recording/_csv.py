"""Importer of one long CSV with one row per sample. Each row repeats the labels of its pinch.

The columns are:

- ``pinch``: name of the pinch, whose rows are consecutive;
- ``piezo_index``, and optionally ``piezo_thumb``. Other sensors use their own name, for example
  ``accelerometer_index_x``, or ``microphone`` if the sensor belongs to no finger;
- optionally ``force_index_0`` to ``force_thumb_5``, ``strip_index`` and ``strip_thumb``;
- optionally ``time_s``;
- with one value per pinch: the labels and contacts of :mod:`firstcontact.recording._labels`;
- with one value for all rows: ``sample_rate_hz``, ``piezo_unit`` (default V), ``force_unit``
  (default V), ``smoothing_alpha``, ``source`` and ``axis``;
- in exported files, ``firstcontact_layout`` in the first row of each pinch: the names and the
  meaning of the signals, which replaces all settings but ``source``.
"""

from __future__ import annotations

from contextlib import suppress
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import TAXELS, Dataset, InputError, VibrationSensor, parse_float, parse_int
from firstcontact.recording._checks import (
    LAYOUT,
    SETTINGS,
    check_force,
    check_rate,
    check_samples,
    check_vibration,
    find_sensor,
    joined,
    make_layout,
    read_settings,
)
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS, labelled
from firstcontact.recording._quoting import quote
from firstcontact.recording._table import Table, read_columns
from firstcontact.recording._table_columns import unknown_columns

FORCE = tuple(f"force_{f}_{k}" for f in ("index", "thumb") for k in range(TAXELS))
STRIP = ("strip_index", "strip_thumb")
_KNOWN = {
    *("pinch", "time_s", "comment"),
    *(*FORCE, *STRIP),
    *(*SETTINGS, LAYOUT, *LABEL_COLUMNS, *CONTACT_COLUMNS),
}
#: Largest relative difference between two statements of the rate.
_RATES_AGREE = 0.01


def import_csv(path: Path, rate: float | None = None) -> Dataset:
    """Import pinches from a long CSV."""
    columns = read_columns(path)
    if "pinch" not in columns:
        raise InputError(
            f"{path} has no column 'pinch': add it, with the number or name of each row's pinch "
            "(one row is one sample)"
        )
    bounds = _bounds(path, columns)
    rows = [(0, bounds[-1][1])]
    given: dict[str, Any] = {
        name: _constant(path, columns, name, rows)[0] for name in SETTINGS if name in columns
    }
    given["sample_rate_hz"] = str(_rate(path, columns, bounds, given.get("sample_rate_hz"), rate))
    sensor = VibrationSensor.PIEZO
    if LAYOUT in columns:
        given[LAYOUT] = _layout_text(path, columns)
    else:
        remedy = "column 'piezo_index': add it (one row is one sample)"
        sensor = find_sensor(str(path), columns, remedy, "_index")
    settings = read_settings(str(path), {f"{sensor}_unit": "V", **given}, sensor)
    sensors = list[list[str]]()
    if settings.layout is not None:
        names = [name.strip() for name in settings.layout.column_names]
    else:
        sensors = _vibration(path, sensor, columns)
        names = [name for of_sensor in sensors for name in of_sensor]
        names += [name for group in (FORCE, STRIP) for name in _all_or_none(path, columns, group)]
    data = joined([_signal(path, columns, name)[:, None] for name in names])

    for column, name in enumerate(names):
        if name in FORCE and settings.layout is None:
            check_force(f"{path}: {name}", data[:, column], settings.force_unit)
    labels = {
        name: _constant(path, columns, name, bounds)
        for name in (*LABEL_COLUMNS, *CONTACT_COLUMNS)
        if name in columns
    }
    of_pinches = columns.of_rows(labels, [start for start, _ in bounds])
    notes = list(settings.notes)
    notes += unknown_columns(path, columns, _KNOWN.union(names))
    layout = settings.layout or make_layout(
        settings,
        len(sensors),
        axes=len(sensors[0]),
        force=FORCE[0] in columns,
        strip=STRIP[0] in columns,
    )
    cuts = [data[start:stop] for start, stop in bounds]
    exported = settings.layout is not None
    return labelled(str(path), cuts, layout, of_pinches, settings.source, notes, exported=exported)


def _layout_text(path: Path, columns: Table) -> str:
    """Return the layout of an exported file, which the first row of each pinch holds."""
    texts = set(columns[LAYOUT]) - {""}
    if len(texts) != 1:
        raise InputError(
            f"{path}: the column '{LAYOUT}' holds {len(texts)} layouts and must hold one: export "
            "the recordings again"
        )
    return texts.pop()


def _vibration(path: Path, sensor: VibrationSensor, columns: Table) -> list[list[str]]:
    """Return the columns of each sensor: of the only one, or of index finger and thumb."""

    def columns_named(named: str) -> list[str]:
        axes = (f"{named}_{axis}" for axis in "xyz")
        return [named] if named in columns else [name for name in axes if name in columns]

    alone = columns_named(sensor)
    columns_by_finger = (
        [alone] if alone else [columns_named(f"{sensor}_index"), columns_named(f"{sensor}_thumb")]
    )
    present = [names for names in columns_by_finger if names]
    if len({len(names) for names in present}) > 1:
        raise InputError(
            f"{path}: the {sensor} of one finger has more axes than the other's: give both the "
            "same columns"
        )
    return present


def _all_or_none(path: Path, columns: Table, names: tuple[str, ...]) -> tuple[str, ...]:
    missing = [n for n in names if n not in columns]
    if 0 < len(missing) < len(names):
        raise InputError(
            f"{path} has no column '{missing[0]}': give all of {names[0]} to {names[-1]}, or none"
        )
    return () if missing else names


def _signal(path: Path, columns: Table, name: str) -> NDArray[Any]:
    """Return a column of samples. Integers stay integers."""
    if name not in columns:
        raise InputError(f"{path} has no column {quote(name)}: add it, or export it again")
    values = np.array(_numbers(path, columns, name, 0, len(columns[name])))
    with suppress(ValueError, OverflowError):  # fractions, and integers beyond 64 bits
        values = np.array([parse_int(cell) for cell in columns[name]], np.int64)
    # Exported files have the precision of float32 already.
    is_vibration = LAYOUT not in columns and name not in (*FORCE, *STRIP)
    check = check_vibration if is_vibration else check_samples
    return check(f"{path}: {name}", values)


def _numbers(path: Path, columns: Table, name: str, start: int, stop: int) -> list[float]:
    """Return the numbers in some rows of a column."""
    numbers = []
    for row in range(start, stop):
        cell = columns[name][row]
        try:
            numbers.append(parse_float(cell))
        except ValueError as error:
            raise InputError(
                f"{path}: '{name}' of {columns.place(row)} is {quote(cell)}, {error}: correct it"
            ) from None
    return numbers


def _bounds(path: Path, columns: Table) -> list[tuple[int, int]]:
    """Return the first row of each pinch, and the row after its last one."""
    bounds = []
    seen = set()
    start = 0
    for name, rows in groupby(columns["pinch"]):
        if name in seen:
            raise InputError(
                f"{path}: pinch {quote(name)} appears again in {columns.place(start)}: put its "
                "rows one after another"
            )
        seen.add(name)
        stop = start + sum(1 for _ in rows)
        bounds.append((start, stop))
        start = stop
    return bounds


def _constant(path: Path, columns: Table, name: str, bounds: list[tuple[int, int]]) -> list[str]:
    """Return a column's value for each pinch. It must be the same in all rows of the pinch."""
    cells = columns[name]
    for start, stop in bounds:
        for row in range(start, stop):
            if cells[row] != cells[start]:
                raise InputError(
                    f"{path}: '{name}' is {quote(cells[start])} in {columns.place(start)} and "
                    f"{quote(cells[row])} in {columns.place(row)}, but must be the same in both: "
                    "correct the rows"
                )
    return [cells[start] for start, _ in bounds]


def _rate(
    path: Path,
    columns: Table,
    bounds: list[tuple[int, int]],
    written: str | None,
    option: float | None,
) -> float:
    """Return the rate. Check that ``--rate``, ``sample_rate_hz`` and ``time_s`` agree on it."""
    statements: list[tuple[str, float]] = []
    if option is not None:
        statements.append(("--rate", check_rate("--rate", option)))
    if written is not None:
        statements.append(("sample_rate_hz", check_rate(f"{path}: sample_rate_hz", written)))
    if "time_s" in columns:
        statements += [("time_s", _rate_of_time(path, columns, *b)) for b in bounds]
    if not statements:
        raise InputError(
            f"{path} does not state its rate: add a column 'time_s' or 'sample_rate_hz', or give "
            "--rate"
        )
    for name, rate in statements[1:]:
        if abs(rate - statements[0][1]) > _RATES_AGREE * statements[0][1]:
            raise InputError(
                f"{path}: '{name}' states {rate:g} Hz, but '{statements[0][0]}' states "
                f"{statements[0][1]:g} Hz: correct one of them"
            )
    return statements[0][1]


def _rate_of_time(path: Path, columns: Table, start: int, stop: int) -> float:
    """Return the mean rate of the rows of a pinch. Check that ``time_s`` rises evenly."""
    times = _numbers(path, columns, "time_s", start, stop)
    if len(times) < 2:
        raise InputError(
            f"{path}: the pinch of {columns.place(start)} has only one sample: remove it"
        )
    step = (times[-1] - times[0]) / (len(times) - 1)
    for row, (a, b) in enumerate(pairwise(times), start + 1):
        if not 0.5 * step < b - a < 1.5 * step:
            raise InputError(
                f"{path}: 'time_s' jumps from {a:g} to {b:g} in {columns.place(row)}: samples are "
                "missing or out of order: leave the pinch out"
            )
    return check_rate(f"{path}: the rate of time_s", 1 / step)


CSV = Importer("csv", "a .csv file", import_csv, suffixes=(".csv",), asks_rate=True)
