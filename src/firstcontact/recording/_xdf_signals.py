"""Selection of the signals among XDF streams, and their unbroken parts."""

from __future__ import annotations

from bisect import bisect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, VibrationSensor
from firstcontact.recording._channel_table import LOWEST_SIGNAL, Signal
from firstcontact.recording._checks import LOWEST_RATE, check_rate
from firstcontact.recording._quoting import listed, quote
from firstcontact.recording._signals import Assembled, Taken, assemble, checked
from firstcontact.recording._stamps import Run, even_runs
from firstcontact.recording._xdf_file import Stream

#: Largest distance of the vibration from the span of another stream, in samples of that stream.
_FARTHEST = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Unbroken samples of all signals. ``run`` gives the times of the vibration's samples."""

    signals: Assembled
    run: Run


def guessed_signals(
    path: Path, streams: Sequence[Stream], sensor: VibrationSensor | None
) -> list[Signal]:
    """Return the signals: the fast stream as the vibration, and all other streams of numbers."""
    numbers = [s for s in streams if not s.is_text and s.rate >= LOWEST_SIGNAL and len(s.stamps)]
    fast = [s for s in numbers if s.rate >= LOWEST_RATE]
    if len(fast) != 1 or fast[0].values.shape[1] > 1:
        kind = (
            f"{len(fast)} streams of numbers at {LOWEST_RATE:g} Hz or more"
            if len(fast) != 1
            else f"a stream {quote(fast[0].name)} of {fast[0].values.shape[1]} channels"
        )
        raise InputError(
            f"{path} has {kind} ({listed([s.name for s in streams])}): name the vibration stream "
            "in a CSV file for --channels"
        )
    kind = sensor or VibrationSensor.PIEZO
    return [
        Signal(s.name, None, kind if s is fast[0] else None, None, None, "", 1.0, 0.0)
        for s in (fast[0], *(s for s in numbers if s is not fast[0]))
    ]


def unbroken_parts(
    path: Path, streams: Sequence[Stream], signals: Sequence[Signal], notes: list[str]
) -> tuple[list[Part], Run]:
    """Return the unbroken parts of a recording, and one run over the whole vibration."""
    by_name = {s.name: s for s in streams}
    for signal in signals:
        _check_signal(path, by_name, signal)
    main = next(by_name[s.variable] for s in signals if s.sensor is not None)
    check_rate(f"{path}: the rate of stream {quote(main.name)}", main.rate)
    runs = {
        name: even_runs(f"{path}: stream {quote(name)}", by_name[name].stamps, by_name[name].rate)
        for name in {s.variable for s in signals}
    }
    if len(runs[main.name]) > 1:
        notes.append(
            f"stream {main.name} has {len(runs[main.name]) - 1} gaps: nothing is joined across them"
        )
    values = {
        (s.variable, s.column): checked(
            f"{path}: stream {quote(s.variable)}", s, by_name[s.variable].values
        )
        for s in signals
    }
    whole = runs.pop(main.name)
    unbroken = _common(path, main.name, whole, runs, notes)
    borders = {name: _borders(others) for name, others in runs.items()}
    parts = []
    for run in unbroken:
        rows: dict[str, slice | NDArray[np.int64]] = {main.name: slice(run.first, run.end)}
        for name, (times, numbers) in borders.items():
            moments = run.moments(by_name[name].rate / main.rate)
            rows[name] = numbers[np.searchsorted(times, moments)]
        taken = [
            Taken(
                s,
                by_name[s.variable].rate,
                values[s.variable, s.column][rows[s.variable]],
                _names(s, by_name[s.variable]),
            )
            for s in signals
        ]
        parts.append(Part(assemble(str(path), taken), run))
    head, tail = whole[0], whole[-1]
    return parts, Run(head.first, tail.end, head.begin, tail.last)


def _check_signal(path: Path, by_name: Mapping[str, Stream], signal: Signal) -> None:
    """Raise an error unless the file has regular numbers for a signal."""
    stream = by_name.get(signal.variable)
    if stream is None:
        raise InputError(
            f"{path} has no stream {quote(signal.variable)} (it has {listed(list(by_name))}): "
            "correct the table of channels"
        )
    content = None
    if stream.is_text:
        content = "texts"
    elif not len(stream.stamps):
        content = "no samples"
    elif stream.rate < LOWEST_SIGNAL or len(stream.stamps) < 2:
        content = f"no regular rate of {LOWEST_SIGNAL:g} Hz or more"
    if content:
        raise InputError(
            f"{path}: stream {quote(stream.name)} has {content}, but a signal needs numbers at "
            "a regular rate: leave it out of the table of channels"
        )
    if signal.rate not in (None, stream.rate):
        raise InputError(
            f"{path}: stream {quote(stream.name)} states {stream.rate:g} Hz, but the table of "
            f"channels states {signal.rate:g} Hz: correct the table"
        )


def _common(
    path: Path, name: str, whole: list[Run], others: Mapping[str, list[Run]], notes: list[str]
) -> list[Run]:
    """Return the runs of the vibration in which all other streams have samples too."""
    unbroken = whole
    for runs in others.values():
        unbroken = _overlaps(unbroken, runs)
    if not unbroken:
        raise InputError(
            f"{path}: the streams have no time in common: remove from the table of channels each "
            "stream that was recorded at another time"
        )
    left = sum(r.end - r.first for r in whole) - sum(r.end - r.first for r in unbroken)
    if left:
        notes.append(
            f"{left / whole[0].rate:.3g} s of {name} are left out: another stream "
            "has no samples there"
        )
    return unbroken


def _overlaps(runs: Sequence[Run], others: Sequence[Run]) -> list[Run]:
    """Return the stretches of ``runs`` in which another stream has samples, the runs ``others``."""
    spans: list[tuple[float, float]] = []
    for run in others:
        margin = _FARTHEST / run.rate
        begin, end = run.begin - margin, run.begin + run.seconds + margin
        if spans and begin <= spans[-1][1]:
            begin, end = spans[-1][0], max(end, spans.pop()[1])
        spans.append((begin, end))
    ends = [end for _, end in spans]
    overlaps = [
        run.between(begin, end)
        for run in runs
        for begin, end in spans[bisect(ends, run.begin) : bisect(spans, (run.last,))]
    ]
    return [run for run in overlaps if run.end - run.first > 1]


def _borders(runs: Sequence[Run]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the times, s, at which the nearest sample changes, and the sample numbers."""
    times = np.concatenate([np.linspace(r.begin, r.last, r.end - r.first) for r in runs])
    return (times[1:] + times[:-1]) / 2, np.concatenate([np.arange(r.first, r.end) for r in runs])


def _names(signal: Signal, stream: Stream) -> tuple[str, ...]:
    """Return the column names. Each consists of the stream's name and the channel's name."""
    wanted = range(len(stream.channels)) if signal.column is None else [signal.column]
    if len(stream.channels) == 1:
        return (signal.variable,)
    return tuple(f"{signal.variable}_{stream.channels[k] or k}" for k in wanted)
