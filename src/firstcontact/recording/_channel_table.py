"""What the signals of a stranger's file are, from a table with a row each.

A signal of a vibration sensor has a ``sensor``; what has none goes along: beside it at the same
rate, or as a slower group of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Finger,
    Group,
    InputError,
    Layout,
    VibrationSensor,
)
from firstcontact.core.layout import MOST_CHANNELS, SCALES
from firstcontact.recording import _cells as cells
from firstcontact.recording.checks import check_rate, check_samples, joined
from firstcontact.recording.quoting import shown
from firstcontact.recording.table import read_rows

#: Two signals of one file may end this many of the slower one's samples apart.
_ENDS_APART = 1.5
#: Slowest rate of a signal that goes along, Hz.
_SLOWEST = 1.0


@dataclass(frozen=True, slots=True)
class Signal:
    """A row of the table: which variable or stream it is of, and what that holds."""

    variable: str
    rate: float | None
    sensor: VibrationSensor | None
    finger: Finger | None
    column: int | None
    unit: str
    scale: float
    offset: float


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """Samples of one signal, shape (samples, columns), at a rate, with the names of columns."""

    signal: Signal
    rate: float
    values: NDArray[np.generic]
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """All signals of a file: the columns of one rate, and slower groups from the same instant."""

    layout: Layout
    data: NDArray[np.generic]
    groups: Mapping[str, NDArray[np.generic]]

    def cut(
        self, start: int, stop: int, dtype: np.dtype[np.generic]
    ) -> tuple[NDArray[np.generic], dict[str, Block]]:
        """Samples from ``start`` on, and of each group those of the same time, in one type."""
        rates = {group.name: group.layout.rate for group in self.layout.groups}
        blocks = {}
        for name, values in self.groups.items():
            pace = rates[name] / self.layout.rate
            first, end = math.ceil(start * pace), math.ceil(stop * pace)
            blocks[name] = Block(np.ascontiguousarray(values[first:end].astype(dtype)), first)
        return np.ascontiguousarray(self.data[start:stop].astype(dtype)), blocks


def read_signals(table: Path) -> list[Signal]:
    """The rows of the table.

    Raises
    ------
    InputError
        Names the line and what in it cannot be used.
    """
    out = []
    for line, row in read_rows(table, ["variable"]):
        where = f"{table}: line {line}"
        if not row["variable"]:
            raise InputError(f"{where} names no variable: give what the file calls the signal")
        out.append(_signal(where, row))
    sensors = {s.sensor for s in out if s.sensor is not None}
    if len(sensors) != 1:
        raise InputError(
            f"{table} has {'no' if not sensors else 'more than one'} kind of sensor: say of the "
            f"vibration signals, and of no others, which of {', '.join(VibrationSensor)} it was"
        )
    return out


def assemble(where: str, taken: Sequence[Taken]) -> Assembled:
    """Columns side by side and slower groups, all cut to the end of the shortest.

    Raises
    ------
    InputError
        Rates or lengths do not fit together, or two signals are of one finger.
    """
    rate = next(t.rate for t in taken if t.signal.sensor is not None)
    other = next((t for t in taken if t.signal.sensor is not None and t.rate != rate), None)
    if other is not None:
        raise InputError(
            f"{where}: vibration signals come at {rate:g} and {other.rate:g} Hz: import them apart"
        )
    faster = next((t for t in taken if t.rate > rate), None)
    if faster is not None:
        raise InputError(
            f"{where}: {faster.names[0]} comes at {faster.rate:g} Hz, faster than the vibration "
            f"({rate:g} Hz): leave it out of the table"
        )
    end = min(len(t.values) / t.rate for t in taken)
    for its in taken:
        if len(its.values) / its.rate > end + _ENDS_APART / min(t.rate for t in taken):
            raise InputError(
                f"{where}: {its.names[0]} lasts {len(its.values) / its.rate:g} s and another "
                f"signal {end:g} s: correct rate_hz of one, or leave it out"
            )
    samples = math.floor(end * rate + 1e-9)
    by_rate: dict[float, list[Taken]] = {}
    for its in taken:
        by_rate.setdefault(its.rate, []).append(its)
    slower = sorted((r for r in by_rate if r != rate), reverse=True)
    groups = tuple(Group(f"{r:g}_hz", Layout(_channels(by_rate[r]), r)) for r in slower)
    layout = Layout(_channels(by_rate[rate]), rate, groups=groups)
    if layout.fault:
        raise InputError(f"{where}: the signals have {layout.fault}: correct the table of channels")
    counts = {r: math.ceil(samples * r / rate) for r in slower}
    return Assembled(
        layout,
        joined([t.values[:samples] for t in by_rate[rate]]),
        {
            group.name: joined([t.values[: counts[r]] for t in by_rate[r]])
            for group, r in zip(groups, slower, strict=True)
        },
    )


def checked(where: str, signal: Signal, values: NDArray[np.generic]) -> NDArray[np.generic]:
    """Samples as recordings keep them, of the one column that is wanted.

    Raises
    ------
    InputError
        The column is not there, or samples are not finite.
    """
    if signal.column is not None:
        if signal.column >= values.shape[1]:
            raise InputError(
                f"{where} has {values.shape[1]} columns and the table asks for column "
                f"{signal.column}: count from 0"
            )
        values = values[:, signal.column : signal.column + 1]
    if signal.sensor is not None and values.shape[1] != 1:
        raise InputError(
            f"{where} has {values.shape[1]} columns: say in column of the table which one is the "
            f"{signal.sensor}'s, from 0"
        )
    return check_samples(where, values)


def common_type(files: Sequence[Assembled]) -> np.dtype[np.generic]:
    """The one type that all samples of a recording have."""
    one_each = [values[:1, :1] for its in files for values in (its.data, *its.groups.values())]
    return joined([np.asarray(v) for v in one_each]).dtype


def _signal(where: str, row: Mapping[str, str]) -> Signal:
    def number(name: str, usual: float) -> float:
        if not row.get(name):
            return usual
        try:
            return cells.number(row[name])
        except ValueError as error:
            raise InputError(
                f"{where}: {name} is {shown(row[name])}, {error}: correct it"
            ) from None

    sensor = row.get("sensor", "").lower()
    if sensor and sensor not in set(VibrationSensor):
        raise InputError(
            f"{where}: sensor is {shown(sensor)} and must be one of {', '.join(VibrationSensor)}, "
            "or empty for what is no vibration"
        )
    try:
        finger = cells.finger(row.get("finger", ""))
    except ValueError as error:
        raise InputError(
            f"{where}: finger is {shown(row['finger'])}, {error}: correct it"
        ) from None
    column = number("column", -1.0)
    if column != int(column) or not -1 <= column < 1 << 31:
        raise InputError(f"{where}: column is {column:g} and must count from 0")
    scale = number("scale", 1.0)
    if not SCALES[0] <= abs(scale) <= SCALES[1]:
        raise InputError(f"{where}: scale is {scale:g}: give units per step")
    rate = None
    if row.get("rate_hz"):
        rate = number("rate_hz", 0.0)
        if sensor:
            check_rate(f"{where}: rate_hz of a {sensor}", rate)
        elif rate < _SLOWEST:
            raise InputError(f"{where}: rate_hz is {rate:g} and must be {_SLOWEST:g} or more")
    return Signal(
        row["variable"],
        rate,
        VibrationSensor(sensor) if sensor else None,
        finger,
        None if column < 0 else int(column),
        row.get("unit", ""),
        scale,
        number("offset", 0.0),
    )


def _channels(taken: Sequence[Taken]) -> tuple[Channel, ...]:
    channels = []
    for its in taken:
        signal = its.signal
        vibration = signal.sensor is not None
        channels += [
            Channel(
                name,
                ChannelKind.VIBRATION if vibration else ChannelKind.FORCE,
                signal.finger,
                signal.unit,
                signal.scale,
                signal.offset,
                sensor=signal.sensor,
                taxel=None if vibration or len(its.names) == 1 else k % MOST_CHANNELS,
            )
            for k, name in enumerate(its.names)
        ]
    return tuple(channels)
