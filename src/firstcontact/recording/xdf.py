"""Import XDF files, as LabRecorder and others write them of Lab Streaming Layer streams.

The vibration is the one stream of numbers at 2 kHz or more, or what ``--channels`` says; slower
streams go along as groups. Contacts are the markers of the one stream of texts, or those of
``--events``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firstcontact.core import Dataset, InputError, VibrationSensor
from firstcontact.recording._channel_table import (
    Assembled,
    Signal,
    Taken,
    assemble,
    checked,
    common_type,
    read_signals,
)
from firstcontact.recording._label_track import label_columns
from firstcontact.recording._labels import labelled
from firstcontact.recording._stamps import Run, even_runs
from firstcontact.recording._xdf_file import Stream, read_xdf
from firstcontact.recording.checks import LOWEST_RATE, check_rate, check_source
from firstcontact.recording.event_table import (
    SAMPLE,
    SECONDS,
    Columns,
    find_events,
    labels_of,
    read_event_table,
    spans,
)
from firstcontact.recording.events import NO_CONTACTS
from firstcontact.recording.formats import Importer
from firstcontact.recording.quoting import listed, shown
from firstcontact.recording.wav import source_of


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """Unbroken samples of all signals; ``run`` is that of the vibration."""

    its: Assembled
    run: Run


def import_xdf(
    path: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    events: Path | None = None,
    channels: Path | None = None,
) -> Dataset:
    """Pinches around the markers of an XDF file.

    Parameters
    ----------
    path
        The file.
    rate
        Not asked for: streams say theirs.
    sensor
        What the vibration was recorded with; a piezo unless said otherwise.
    events
        Table of the contacts, in seconds or samples from the first of the vibration; the
        markers are then not looked at.
    channels
        Which streams are wanted, and what they are.

    Raises
    ------
    InputError
        Names the stream, or the row of a table, that cannot be used.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder: give one .xdf file")
    streams = read_xdf(path)
    _check(path, streams)
    signals = _guessed(path, streams, sensor) if channels is None else read_signals(channels)
    if channels is not None and sensor is not None:
        raise InputError(f"{channels} says what the sensor is: leave --sensor out")
    notes = [
        f"stream {s.name}: its recording was not ended properly, samples may lack at the end"
        for s in streams
        if not s.closed
    ]
    parts, begin = _parts(path, streams, signals, notes)
    columns, table = _contacts(path, streams, begin, events, notes)
    source = source_of(table, columns) if columns else check_source(str(path), "unknown")
    pace = parts[0].its.layout.rate
    lengths = [len(part.its.data) for part in parts]
    if not columns:
        notes.append(NO_CONTACTS)
        starts, stops, of = [0] * len(parts), lengths, list(range(len(parts)))
        given: Columns = {}
    else:
        rows, local = _placed(table, columns, parts, begin)
        found = find_events(
            table, local, rows, [path] * len(parts), [(n, 1) for n in lengths], pace
        )
        starts, stops = spans(found, lengths, pace)
        of = [event.file for event in found]
        given, left_out = labels_of(table, columns, found, starts)
        notes += left_out
    given.setdefault("session", [path.stem] * len(of))
    dtype = common_type([part.its for part in parts])
    cuts = [parts[k].its.cut(a, b, dtype) for k, a, b in zip(of, starts, stops, strict=True)]
    return labelled(
        str(table),
        [data for data, _ in cuts],
        parts[0].its.layout,
        given,
        source,
        notes,
        starts=starts,
        groups=[groups for _, groups in cuts],
    )


def _check(path: Path, streams: Sequence[Stream]) -> None:
    names = [s.name for s in streams]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise InputError(
            f"{path} has two streams of the name {shown(doubled[0])}: record them again under "
            "names of their own, or remove one"
        )
    for stream in streams:
        if not np.isfinite(stream.stamps).all():
            raise InputError(
                f"{path}: stream {shown(stream.name)} has time stamps that are no numbers: record "
                "it again"
            )


def _guessed(path: Path, streams: Sequence[Stream], sensor: VibrationSensor | None) -> list[Signal]:
    """The fast stream as the vibration, and what goes along with it."""
    numbers = [s for s in streams if not s.says and s.rate and len(s.stamps)]
    fast = [s for s in numbers if s.rate >= LOWEST_RATE]
    if len(fast) != 1 or fast[0].values.shape[1] > 1:
        what = (
            f"{len(fast)} streams of numbers at {LOWEST_RATE:g} Hz or more"
            if len(fast) != 1
            else f"a stream {shown(fast[0].name)} of {fast[0].values.shape[1]} channels"
        )
        raise InputError(
            f"{path} has {what} ({listed([s.name for s in streams])}): say in a table which is the "
            "vibration, with --channels"
        )
    what = sensor or VibrationSensor.PIEZO
    return [
        Signal(s.name, None, what if s is fast[0] else None, None, None, "", 1.0, 0.0)
        for s in (fast[0], *(s for s in numbers if s is not fast[0]))
    ]


def _parts(
    path: Path, streams: Sequence[Stream], signals: Sequence[Signal], notes: list[str]
) -> tuple[list[_Part], float]:
    """Unbroken stretches of the vibration, and what of the other signals lies beside each.

    With them the time of the vibration's first sample, which may lie in a stretch that is left out.
    """
    by_name = {s.name: s for s in streams}
    for signal in signals:
        stream = by_name.get(signal.variable)
        if stream is None:
            raise InputError(
                f"{path} has no stream {shown(signal.variable)} (it has {listed(list(by_name))}): "
                "correct the table of channels"
            )
        if stream.says or not stream.rate or len(stream.stamps) < 2:
            what = (
                "texts" if stream.says else "no regular rate" if stream.stamps.size else "nothing"
            )
            raise InputError(
                f"{path}: stream {shown(stream.name)} has {what}, and a signal has numbers at a "
                "regular rate: leave it out of the table of channels"
            )
        if signal.rate not in (None, stream.rate):
            raise InputError(
                f"{path}: stream {shown(stream.name)} says {stream.rate:g} Hz and the table "
                f"{signal.rate:g} Hz: correct the table"
            )
    main = next(by_name[s.variable] for s in signals if s.sensor is not None)
    check_rate(f"{path}: the rate of stream {shown(main.name)}", main.rate)
    runs = {
        name: even_runs(f"{path}: stream {shown(name)}", by_name[name].stamps, by_name[name].rate)
        for name in {s.variable for s in signals}
    }
    if len(runs[main.name]) > 1:
        notes.append(
            f"stream {main.name} has {len(runs[main.name]) - 1} gaps: nothing is joined across them"
        )
    values = {
        (s.variable, s.column): checked(
            f"{path}: stream {shown(s.variable)}", s, by_name[s.variable].values
        )
        for s in signals
    }
    parts = []
    for run in runs[main.name]:
        beside = []
        for signal in signals:
            stream = by_name[signal.variable]
            its = next((r for r in runs[stream.name] if r.covers(run)), None)
            if its is None:
                break
            # The sample of it that is nearest to the first of the vibration.
            first = max(0, round((run.begin - its.begin) * its.rate))
            most = math.ceil(run.seconds * stream.rate)
            data = values[signal.variable, signal.column][its.first + first : its.end]
            beside.append(Taken(signal, stream.rate, data[:most], _names(signal, stream)))
        if len(beside) < len(signals):
            notes.append(
                f"{run.seconds:.3g} s of {main.name} are left out: another stream lacks there"
            )
            continue
        parts.append(_Part(assemble(str(path), beside), run))
    if not parts:
        raise InputError(
            f"{path}: the streams have no time in common: leave those out of the table of channels "
            "that were not recorded together"
        )
    return parts, runs[main.name][0].begin


def _names(signal: Signal, stream: Stream) -> tuple[str, ...]:
    """Of its columns: as the stream says, with the stream's before it."""
    wanted = range(len(stream.channels)) if signal.column is None else [signal.column]
    if len(stream.channels) == 1:
        return (signal.variable,)
    return tuple(f"{signal.variable}_{stream.channels[k] or k}" for k in wanted)


def _contacts(
    path: Path,
    streams: Sequence[Stream],
    begin: float,
    events: Path | None,
    notes: list[str],
) -> tuple[Columns, Path]:
    """A table of the contacts in seconds from the vibration's first sample, or nothing."""
    if events is not None:
        return read_event_table(events), events
    says = [s for s in streams if s.says and len(s.stamps)]
    if len(says) > 1:
        raise InputError(
            f"{path} has several streams of texts ({listed([s.name for s in says])}): give the "
            "contacts with --events"
        )
    if not says:
        return {}, path
    texts = [str(text) for text in says[0].values[:, 0]]
    seconds = [f"{float(stamp - begin)!r}" for stamp in says[0].stamps]
    notes.append(f"contacts are the {len(texts)} markers of stream {says[0].name}")
    return {SECONDS: seconds, **label_columns(f"{path}: stream {says[0].name}", texts)}, path


def _placed(
    table: Path, columns: Columns, parts: Sequence[_Part], begin: float
) -> tuple[list[int | None], Columns]:
    """Which part each row lies in, and the columns counted from the start of that part."""
    whole = len(parts) == 1 and parts[0].run.begin == begin
    if whole or (SECONDS in columns) == (SAMPLE in columns):
        return [0] * len(next(iter(columns.values()))), columns
    name = SECONDS if SECONDS in columns else SAMPLE
    bounds = [
        (p.run.begin - begin, p.run.last - begin)
        if name == SECONDS
        else (p.run.first, p.run.end - 1)
        for p in parts
    ]
    rows: list[int | None] = []
    local: list[str] = []
    for row, cell in enumerate(columns[name]):
        try:
            at = float(cell)
        except ValueError:
            at = np.nan
        place = next((k for k, (a, b) in enumerate(bounds) if a <= at <= b), None)
        if place is None:
            raise InputError(
                f"{table}: {name} of row {row} is {shown(cell)}, where the vibration has no "
                "samples, or another stream lacks: correct or remove the row"
            )
        rows.append(place)
        local.append(f"{at - bounds[place][0]!r}")
    return rows, {**columns, name: local}


XDF = Importer(
    "xdf",
    "an .xdf file",
    import_xdf,
    suffixes=(".xdf",),
    asks_sensor=True,
    asks_events=True,
    asks_channels=True,
    extra="files",
    modules=("pyxdf",),
)
