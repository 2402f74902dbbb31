"""Table of channels: describes the signals of a file, one per row.

A signal with a ``sensor`` is a vibration. A signal without a ``sensor`` and with the vibration's
rate becomes further columns beside it. Slower signals become groups, one for each rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from firstcontact.core import SCALES, Finger, InputError, VibrationSensor
from firstcontact.recording import _cells as cells
from firstcontact.recording._checks import check_rate
from firstcontact.recording._quoting import quote
from firstcontact.recording._table import read_rows

#: Lowest rate of a signal without a sensor, Hz.
LOWEST_SIGNAL = 1.0


@dataclass(frozen=True, slots=True)
class Signal:
    """Row of a table of channels: a variable or stream, and its meaning."""

    variable: str
    rate: float | None
    sensor: VibrationSensor | None
    finger: Finger | None
    column: int | None
    unit: str
    scale: float
    offset: float


def read_signals(table: Path) -> list[Signal]:
    """Return the rows of a table of channels."""
    out = []
    for line, row in read_rows(table, ["variable"]):
        origin = f"{table}: line {line}"
        if not row["variable"]:
            raise InputError(
                f"{origin} has nothing in the column 'variable': give the name of the signal in "
                "the file"
            )
        out.append(_signal(origin, row))
    sensors = {s.sensor for s in out if s.sensor is not None}
    if len(sensors) != 1:
        raise InputError(
            f"{table} has {('no' if not sensors else 'more than one')} kind of sensor: give all "
            f"vibration signals the same 'sensor', one of {', '.join(VibrationSensor)}, and leave "
            "it empty for other signals"
        )
    return out


def _signal(origin: str, row: Mapping[str, str]) -> Signal:
    def number(name: str, usual: float) -> float:
        if not row.get(name):
            return usual
        try:
            return cells.number(row[name])
        except ValueError as error:
            raise InputError(
                f"{origin}: '{name}' is {quote(row[name])}, {error}: correct it"
            ) from None

    sensor = row.get("sensor", "").lower()
    if sensor and sensor not in set(VibrationSensor):
        raise InputError(
            f"{origin}: 'sensor' is {quote(sensor)} and must be one of "
            f"{', '.join(VibrationSensor)}, or empty for other signals"
        )
    try:
        finger = cells.finger(row.get("finger", ""))
    except ValueError as error:
        raise InputError(
            f"{origin}: 'finger' is {quote(row['finger'])}, {error}: correct it"
        ) from None
    column = number("column", 0.0) if row.get("column") else None
    if column is not None and not (column == int(column) and 0 <= column < 1 << 31):
        raise InputError(
            f"{origin}: 'column' is {quote(row['column'])} and must be a whole number from 0 on: "
            "correct it, or leave it empty"
        )
    scale = number("scale", 1.0)
    if not SCALES[0] <= abs(scale) <= SCALES[1]:
        raise InputError(
            f"{origin}: 'scale' is {scale:g}: give the units of one step of the converter, a "
            "number other than 0"
        )
    rate = None
    if row.get("rate_hz"):
        rate = number("rate_hz", 0.0)
        if sensor:
            check_rate(f"{origin}: 'rate_hz' of a {sensor}", rate)
        elif rate < LOWEST_SIGNAL:
            raise InputError(
                f"{origin}: 'rate_hz' is {rate:g} and must be {LOWEST_SIGNAL:g} or more"
            )
    return Signal(
        row["variable"],
        rate,
        VibrationSensor(sensor) if sensor else None,
        finger,
        None if column is None else int(column),
        row.get("unit", ""),
        scale,
        number("offset", 0.0),
    )
