"""Importer of XDF files, which LabRecorder and others write from Lab Streaming Layer streams.

The vibration is the only stream of numbers at 2 kHz or more, or the one that a table of channels
names. Slower streams become groups. Contacts are the markers of the only stream of texts, or come
from a table of events.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from firstcontact.core import Dataset, InputError, VibrationSensor, counted, parse_float
from firstcontact.recording._channel_table import LOWEST_SIGNAL, read_signals
from firstcontact.recording._checks import HIGHEST_RATE
from firstcontact.recording._event_table import (
    SAMPLE,
    SECONDS,
    Columns,
    event_labels,
    find_events,
    read_event_table,
    spans,
)
from firstcontact.recording._events import NO_CONTACTS
from firstcontact.recording._formats import Importer
from firstcontact.recording._label_track import label_columns
from firstcontact.recording._quoting import listed, quote
from firstcontact.recording._signals import cut_pinches
from firstcontact.recording._stamps import Run, check_stamps
from firstcontact.recording._table_columns import stated_source
from firstcontact.recording._xdf_file import Stream, read_xdf
from firstcontact.recording._xdf_signals import Part, guessed_signals, unbroken_parts


def import_xdf(
    path: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    events: Path | None = None,
    channels: Path | None = None,
) -> Dataset:
    """Import pinches around the markers of an XDF file."""
    if path.is_dir():
        raise InputError(f"{path} is a folder: give one .xdf file")
    streams = read_xdf(path)
    _check(path, streams)
    signals = guessed_signals(path, streams, sensor) if channels is None else read_signals(channels)
    if channels is not None and sensor is not None:
        raise InputError(f"{channels} already states the sensor: leave --sensor out")
    notes = [
        f"stream {s.name}: its recording did not end properly, so samples may be missing at the end"
        for s in streams
        if not s.closed
    ]
    irregular = [
        s.name for s in streams if not s.is_text and s.rate < LOWEST_SIGNAL and len(s.stamps)
    ]
    if irregular:
        notes.append(
            f"streams of numbers without a regular rate of {LOWEST_SIGNAL:g} Hz or more were left "
            f"out: {listed(irregular)}; if they mark contacts, give the times with --events"
        )
    parts, vibration = unbroken_parts(path, streams, signals, notes)
    columns, table = _contacts(path, streams, vibration.begin, events, notes)
    source = stated_source(table, columns)
    pace = parts[0].signals.layout.rate
    lengths = [len(part.signals.data) for part in parts]
    if not columns:
        notes.append(NO_CONTACTS)
        starts, stops, of = [0] * len(parts), lengths, list(range(len(parts)))
        given = Columns({}, ())
    else:
        rows, local = _placed(table, columns, parts, vibration, notes)
        shapes, rates = [(n, 1) for n in lengths], [part.run.rate for part in parts]
        contacts = find_events(table, local, rows, [path] * len(parts), shapes, rates)
        starts, stops = spans(contacts, lengths, pace)
        of = [event.file for event in contacts]
        given, left_out = event_labels(table, columns, contacts, starts)
        notes += left_out
    given.setdefault("session", [path.stem] * len(of))
    places = list(zip(of, starts, stops, strict=True))
    return cut_pinches(table, [part.signals for part in parts], places, given, source, notes)


def _check(path: Path, streams: Sequence[Stream]) -> None:
    names = [s.name for s in streams]
    doubled = sorted({name for name in names if names.count(name) > 1})
    if doubled:
        raise InputError(
            f"{path} has two streams named {quote(doubled[0])}: record them again under "
            "different names, or remove one"
        )
    for stream in streams:
        if not 0 <= stream.rate <= HIGHEST_RATE:
            raise InputError(
                f"{path}: stream {quote(stream.name)} states {stream.rate:g} Hz, which is outside "
                f"of 0 (no regular rate) to {HIGHEST_RATE:g} Hz: record it again"
            )
        check_stamps(f"{path}: stream {quote(stream.name)}", stream.stamps)


def _contacts(
    path: Path,
    streams: Sequence[Stream],
    begin: float,
    events: Path | None,
    notes: list[str],
) -> tuple[Columns, Path]:
    """Return the table of the contacts, and the path of the file that it comes from."""
    if events is not None:
        return read_event_table(events), events
    text_streams = [s for s in streams if s.is_text and len(s.stamps)]
    if len(text_streams) > 1:
        raise InputError(
            f"{path} has several streams of texts ({listed([s.name for s in text_streams])}): give "
            "the contacts with --events"
        )
    if not text_streams:
        return Columns({}, ()), path
    (stream,) = text_streams
    texts = [str(text) for text in stream.values[:, 0]]
    seconds = [f"{float(stamp - begin)!r}" for stamp in stream.stamps]
    notes.append(f"contacts are the {counted(len(texts), 'marker')} of stream {stream.name}")
    marks = Columns({SECONDS: seconds}, range(1, len(texts) + 1), "marker")
    return label_columns(f"{path}: stream {stream.name}", marks, texts), path


def _placed(
    table: Path, columns: Columns, parts: Sequence[Part], vibration: Run, notes: list[str]
) -> tuple[list[int | None], Columns]:
    """Return the number of the part in which each contact lies, and the columns."""
    unbroken = len(parts) == 1 and parts[0].run == vibration
    if unbroken or (SECONDS in columns) == (SAMPLE in columns):
        return [0] * len(next(iter(columns.values()))), columns
    name = SECONDS if SECONDS in columns else SAMPLE
    bounds = [_bounds(name, part.run, vibration) for part in parts]
    end = _bounds(name, vibration, vibration)[1]
    rows: list[int | None] = []
    local: list[str] = []
    for row, cell in enumerate(columns[name]):
        try:
            at = parse_float(cell)
        except ValueError:
            at = np.nan
        place = next((k for k, (a, b) in enumerate(bounds) if a <= at <= b), None)
        if place is None and not 0 <= at <= end:
            raise InputError(
                f"{table}: '{name}' of {columns.place(row)} is {quote(cell)}, where the vibration "
                "has no samples: correct or remove the row"
            )
        rows.append(place)
        local.append(cell if place is None else f"{at - bounds[place][0]!r}")
    left = rows.count(None)
    if left == len(rows):
        raise InputError(
            f"{table}: each of its {left} contacts lies in a gap, or where another stream has no "
            "samples: record the streams together, or leave one out of the table of channels"
        )
    if left:
        notes.append(
            f"{left} of {len(rows)} contacts lie in a gap, or where another stream has no samples: "
            "they are left out"
        )
    return rows, columns.of_rows({**columns, name: local}, range(len(rows)))


def _bounds(name: str, run: Run, vibration: Run) -> tuple[float, float]:
    """Return the positions of a run's first and last sample, counted from the vibration's start."""
    if name == SECONDS:
        return run.begin - vibration.begin, run.last - vibration.begin
    return run.first, run.end - 1


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
