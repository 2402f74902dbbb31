"""Assembly of a file's signals: columns of one rate, slower groups, and pinches."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    MOST_CHANNELS,
    Block,
    Channel,
    ChannelKind,
    Dataset,
    Group,
    InputError,
    Layout,
)
from firstcontact.recording._cells import Columns
from firstcontact.recording._channel_table import Signal
from firstcontact.recording._checks import check_samples, check_vibration, joined
from firstcontact.recording._labels import labelled

#: Largest difference between the ends of two signals, in samples of the slower one.
_ENDS_APART = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Taken:
    """Samples of one signal, shape (samples, columns), with rate and column names."""

    signal: Signal
    rate: float
    values: NDArray[np.generic]
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """Signals of a file: columns of one rate, and slower groups that start at the same time."""

    layout: Layout
    data: NDArray[np.generic]
    groups: Mapping[str, NDArray[np.generic]]

    def cut(
        self, start: int, stop: int, dtype: np.dtype[np.generic]
    ) -> tuple[NDArray[np.generic], dict[str, Block]]:
        """Return the samples ``start`` to ``stop``, and each group's samples of the same time."""
        rates = {group.name: group.layout.rate for group in self.layout.groups}
        blocks = {}
        for name, values in self.groups.items():
            pace = rates[name] / self.layout.rate
            first, end = math.ceil(start * pace), math.ceil(stop * pace)
            blocks[name] = Block(np.ascontiguousarray(values[first:end].astype(dtype)), first)
        return np.ascontiguousarray(self.data[start:stop].astype(dtype)), blocks


def assemble(origin: str, taken: Sequence[Taken]) -> Assembled:
    """Return signals as columns and slower groups, all cut to the end of the shortest signal."""
    rate = next(t.rate for t in taken if t.signal.sensor is not None)
    other = next((t for t in taken if t.signal.sensor is not None and t.rate != rate), None)
    if other is not None:
        raise InputError(
            f"{origin}: the vibration signals have different rates, {rate:g} and {other.rate:g} "
            "Hz: import them separately"
        )
    faster = next((t for t in taken if t.rate > rate), None)
    if faster is not None:
        raise InputError(
            f"{origin}: {faster.names[0]} comes at {faster.rate:g} Hz, faster than the vibration "
            f"({rate:g} Hz): leave it out of the table of channels"
        )
    end = min(len(t.values) / t.rate for t in taken)
    for signal in taken:
        if len(signal.values) / signal.rate > end + _ENDS_APART / min(t.rate for t in taken):
            raise InputError(
                f"{origin}: {signal.names[0]} lasts {len(signal.values) / signal.rate:g} s, but "
                f"another signal lasts {end:g} s: correct the 'rate_hz' of one of them, or leave "
                "one out"
            )
    samples = math.floor(end * rate + 1e-9)
    by_rate: dict[float, list[Taken]] = {}
    for signal in taken:
        by_rate.setdefault(signal.rate, []).append(signal)
    slower = sorted((r for r in by_rate if r != rate), reverse=True)
    groups = tuple(Group(f"{r:g}_hz", Layout(_channels(by_rate[r]), r)) for r in slower)
    layout = Layout(_channels(by_rate[rate]), rate, groups=groups)
    if layout.fault:
        raise InputError(
            f"{origin}: the signals have {layout.fault}: correct the table of channels"
        )
    counts = {r: math.ceil(samples * r / rate) for r in slower}
    return Assembled(
        layout,
        joined([t.values[:samples] for t in by_rate[rate]]),
        {
            group.name: joined([t.values[: counts[r]] for t in by_rate[r]])
            for group, r in zip(groups, slower, strict=True)
        },
    )


def checked(origin: str, signal: Signal, values: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return the samples of a signal's column in a type that recordings store, after checks."""
    if signal.column is not None:
        if signal.column >= values.shape[1]:
            raise InputError(
                f"{origin} has {values.shape[1]} columns, but the table of channels asks for "
                f"column {signal.column}: give the column's number, counted from 0"
            )
        values = values[:, signal.column : signal.column + 1]
    if signal.sensor is not None and values.shape[1] != 1:
        raise InputError(
            f"{origin} has {values.shape[1]} columns: give the number of the {signal.sensor}'s "
            "column, from 0, in the column 'column' of the table of channels"
        )
    return (check_samples if signal.sensor is None else check_vibration)(origin, values)


def cut_pinches(
    table: Path,
    recordings: Sequence[Assembled],
    places: Sequence[tuple[int, int, int]],
    columns: Columns,
    source: str,
    notes: Sequence[str],
) -> Dataset:
    """Cut pinches from assembled signals, all in one sample type."""
    one_each = [
        values[:1, :1] for signal in recordings for values in (signal.data, *signal.groups.values())
    ]
    dtype = joined([np.asarray(v) for v in one_each]).dtype
    cuts = [recordings[k].cut(start, stop, dtype) for k, start, stop in places]
    return labelled(
        str(table),
        [data for data, _ in cuts],
        recordings[0].layout,
        columns,
        source,
        notes,
        starts=[start for _, start, _ in places],
        groups=[groups for _, groups in cuts],
    )


def _channels(taken: Sequence[Taken]) -> tuple[Channel, ...]:
    channels = []
    for samples in taken:
        signal = samples.signal
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
                taxel=None if vibration or len(samples.names) == 1 else k % MOST_CHANNELS,
            )
            for k, name in enumerate(samples.names)
        ]
    return tuple(channels)
