"""Signals that a table of channels names: main columns of one rate, and groups of slower ones.

A signal with a ``sensor`` is a vibration. A signal without a ``sensor`` and with the vibration's
rate becomes further columns beside it. Slower signals become groups, one for each rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    Block,
    Channel,
    ChannelKind,
    Dataset,
    FileError,
    Finger,
    Group,
    Layout,
    VibrationSensor,
)
from firstcontact.core.layout import MOST_CHANNELS, SCALES
from firstcontact.core.text import counted
from firstcontact.core.units import fit_unit, known_unit
from firstcontact.recording._labels import (
    bounded,
    choice,
    make_dataset,
    parse_finger,
    parse_name,
    parse_number,
    parse_text,
    parse_whole,
)
from firstcontact.recording.settings import (
    HIGHEST_RATE,
    LOWEST_RATE,
    check_samples,
    check_vibration,
    common_type,
    joined,
)
from firstcontact.recording.table import Table, read_rows

#: Lowest rate of a signal without a sensor, Hz.
LOWEST_SIGNAL = 1.0
#: Column of a matrix whose columns follow each other in time, as MATLAB's x(:) reads them.
ALL = -1
#: Largest difference between the ends of two signals, in samples of the slower one.
_ENDS_APART = 1.5


@dataclass(frozen=True, slots=True)
class Signal:
    """Row of a table of channels, which describes one signal in a file.

    ``variable`` is the name of the MATLAB variable or XDF stream. ``column`` is the column to use
    in it, from 0; None means all, and ``ALL`` one after the other. ``sensor`` is None for signals
    other than vibrations. ``(number - offset) * scale`` is the value in ``unit``.
    """

    variable: str
    rate: float | None = None
    sensor: VibrationSensor | None = None
    finger: Finger | None = None
    column: int | None = None
    unit: str = ""
    scale: float = 1.0
    offset: float = 0.0


def read_signals(path: Path) -> list[Signal]:
    """Read a table of channels (a CSV file). Raise FileError unless it has one kind of sensor."""
    rows = read_rows(path, ["variable"])
    cells = {name: [row.get(name, "") for _, row in rows] for name in _PARSERS}
    table = Table(path, cells, [line for line, _ in rows])
    columns = [table.parsed(name, parse) for name, parse in _PARSERS.items()]
    signals = [Signal(*row) for row in zip(*columns, strict=True)]
    for row, signal in enumerate(signals):
        if signal.sensor is not None and signal.rate is not None and signal.rate < LOWEST_RATE:
            reason = f"but a vibration needs {LOWEST_RATE:g} Hz or more"
            raise table.refusal("rate_hz", row, reason, "give the rate in Hz")
    kinds = {signal.sensor for signal in signals} - {None}
    if len(kinds) != 1:
        raise FileError(
            f"{path} has {'more than one' if kinds else 'no'} kind of sensor: give all vibration "
            f"signals the same 'sensor', one of {', '.join(VibrationSensor)}, and leave it empty "
            "for other signals"
        )
    return signals


def _optional(parse: Callable[[str], Any], absent: Any = None) -> Callable[[str], Any]:
    return lambda cell: parse(cell) if cell else absent


def _parse_scale(cell: str) -> float:
    scale = parse_number(cell)
    if not SCALES[0] <= abs(scale) <= SCALES[1]:
        raise ValueError(
            "which must be the size of one step of the converter in the signal's unit, and not 0"
        )
    return scale


def _parse_column(cell: str) -> int:
    return ALL if cell.lower() == "all" else int(bounded(parse_whole, 0, 1 << 31)(cell))


#: Parsers of the columns, in the order of the fields of :class:`Signal`.
_PARSERS: Mapping[str, Callable[[str], Any]] = {
    "variable": parse_name,
    "rate_hz": _optional(bounded(parse_number, LOWEST_SIGNAL, HIGHEST_RATE)),
    "sensor": _optional(choice(VibrationSensor)),
    "finger": parse_finger,
    "column": _optional(_parse_column),
    "unit": parse_text,
    "scale": _optional(_parse_scale, 1.0),
    "offset": _optional(parse_number, 0.0),
}


@dataclass(frozen=True, slots=True, eq=False)
class SignalSamples:
    """Samples of one signal, with the names of their columns.

    ``values`` has the shape (samples, columns), and ``rate`` is in Hz.
    """

    signal: Signal
    rate: float
    values: NDArray[np.generic]
    names: tuple[str, ...]


def select_samples(
    origin: str,
    signal: Signal,
    rate: float,
    values: NDArray[np.generic],
    labels: Sequence[str] = (),
) -> SignalSamples:
    """Return the samples of a signal, checked and in a data type that recordings store.

    ``values`` has the shape (samples, columns) and ``rate`` is in Hz. ``labels`` are the names of
    the columns. Raises FileError, with the name ``origin``, for an unusable column.
    """
    width = values.shape[1]
    columns: Sequence[int] = range(width)
    if signal.column is not None:
        if not 0 <= signal.column < width:
            raise FileError(
                f"{origin} has {counted(width, 'column')}, but the table of channels asks for "
                f"column {'all' if signal.column == ALL else signal.column}: give the column's "
                "number, counted from 0"
            )
        columns, values = [signal.column], values[:, signal.column : signal.column + 1]
    if signal.sensor is not None and len(columns) != 1:
        raise FileError(
            f"{origin} has {width} columns: give the number of the {signal.sensor}'s column, from "
            "0, in the column 'column' of the table of channels, or for MATLAB 'all' if its "
            "columns follow each other in time"
        )
    values = (check_samples if signal.sensor is None else check_vibration)(origin, values)
    if signal.sensor is not None:
        signal = _in_known_unit(origin, signal, values)
    ends = [f"_{(labels and labels[k]) or k}" for k in columns] if width > 1 else [""]
    names = tuple(f"{signal.variable}{end}" for end in ends)
    return SignalSamples(signal, rate, values, names)


def _in_known_unit(origin: str, signal: Signal, values: NDArray[np.generic]) -> Signal:
    """Return the signal in V, m/s2 or Pa if its unit can be converted, else unchanged."""
    unit = known_unit(signal.unit)
    if (signal.scale, signal.offset) != (1.0, 0.0):
        scale, offset = signal.scale * unit.scale, signal.offset + unit.offset / signal.scale
        if not SCALES[0] <= abs(scale) <= SCALES[1]:
            return signal
        unit = replace(unit, scale=scale, offset=offset, bits=None)
    if unit.bits is not None:
        unit = fit_unit(f"{origin} ('unit')", unit, values)
    return replace(signal, unit=unit.name, scale=unit.scale, offset=unit.offset)


@dataclass(frozen=True, slots=True, eq=False)
class Signals:
    """Signals of one file: the columns of the main rate, and slower groups by name.

    All arrays have the shape (samples, columns) and start at the same time.
    """

    layout: Layout
    data: NDArray[np.generic]
    groups: Mapping[str, NDArray[np.generic]]

    def cut(
        self, start: int, stop: int, dtype: np.dtype[np.generic]
    ) -> tuple[NDArray[np.generic], dict[str, Block]]:
        """Return the main samples ``start`` to ``stop`` (exclusive), and blocks of slower groups.

        The blocks are by name of the group. ``dtype`` is the type of all returned samples.
        """
        blocks = {}
        for group in self.layout.groups:
            pace = group.layout.rate / self.layout.rate
            first, end = math.ceil(start * pace), math.ceil(stop * pace)
            values = self.groups[group.name][first:end]
            blocks[group.name] = Block(np.ascontiguousarray(values.astype(dtype)), first)
        return np.ascontiguousarray(self.data[start:stop].astype(dtype)), blocks


def combine(origin: str, parts: Sequence[SignalSamples]) -> Signals:
    """Combine the signals of a file, cut to the end of the shortest one.

    Signals with the vibration's rate become the main columns; slower ones become groups. Raises
    FileError if rates or lengths do not fit.
    """
    rate = next(part.rate for part in parts if part.signal.sensor is not None)
    end = min(len(part.values) / part.rate for part in parts)
    slowest = min(part.rate for part in parts)
    by_rate: dict[float, list[SignalSamples]] = {}
    for part in parts:
        seconds = len(part.values) / part.rate
        by_rate.setdefault(part.rate, []).append(part)
        if part.rate > rate or (part.signal.sensor is not None and part.rate != rate):
            raise FileError(
                f"{origin}: {part.names[0]} has {part.rate:g} Hz, but all vibrations must have "
                f"{rate:g} Hz, and other signals at most that: leave it out of the channel table"
            )
        if seconds > end + _ENDS_APART / slowest:
            raise FileError(
                f"{origin}: {part.names[0]} lasts {seconds:g} s, but another signal lasts {end:g} "
                "s: correct the 'rate_hz' of one of them, or leave one out"
            )
    slower = {f"{r:g}_hz": r for r in sorted(by_rate, reverse=True) if r != rate}
    groups = tuple(Group(name, Layout(_channels(by_rate[r]), r)) for name, r in slower.items())
    layout = Layout(_channels(by_rate[rate]), rate, groups=groups)
    if layout.why_unusable:
        raise FileError(
            f"{origin}: the signals have {layout.why_unusable}: correct the table of channels"
        )
    samples = math.floor(end * rate + 1e-9)

    def columns(r: float) -> NDArray[np.generic]:
        count = samples if r == rate else math.ceil(samples * r / rate)
        return joined([part.values[:count] for part in by_rate[r]])

    return Signals(layout, columns(rate), {name: columns(r) for name, r in slower.items()})


def _channels(parts: Sequence[SignalSamples]) -> tuple[Channel, ...]:
    return tuple(
        Channel(
            name,
            ChannelKind.FORCE if part.signal.sensor is None else ChannelKind.VIBRATION,
            part.signal.finger,
            part.signal.unit,
            part.signal.scale,
            part.signal.offset,
            sensor=part.signal.sensor,
            taxel=None if len(part.names) == 1 else k % MOST_CHANNELS,
        )
        for part in parts
        for k, name in enumerate(part.names)
    )


def cut_pinches(
    table: Table,
    files: Sequence[Signals],
    places: Sequence[tuple[int, int, int]],
    notes: Sequence[str],
) -> Dataset:
    """Cut pinches from files and make a dataset, with all samples in one data type.

    ``table`` has the labels. ``places`` has, for each pinch, the index of its file, its first
    sample, and the sample after the last one.
    """
    dtype = common_type([v for file in files for v in (file.data, *file.groups.values())])
    cuts = [files[k].cut(start, stop, dtype) for k, start, stop in places]
    return make_dataset(
        table,
        [data for data, _ in cuts],
        files[0].layout,
        notes=notes,
        starts=[start for _, start, _ in places],
        groups=[groups for _, groups in cuts],
    )
