"""Importer of XDF files, which LabRecorder and others write from Lab Streaming Layer streams.

The vibration is the only stream of numbers at 500 Hz or more, or the one that a table of channels
names. Slower streams become groups. Contacts are the markers of the only stream of texts, or come
from a table of events.
"""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from logging.handlers import BufferingHandler
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, FileError, VibrationSensor
from firstcontact.core.files import open_regular
from firstcontact.core.text import counted
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import parse_number
from firstcontact.recording._runs import Nearest, Run, even_runs, overlaps
from firstcontact.recording._signals import (
    LOWEST_SIGNAL,
    Signal,
    Signals,
    combine,
    cut_pinches,
    read_signals,
    select_samples,
)
from firstcontact.recording.events import (
    NO_CONTACTS,
    SECONDS,
    add_labels,
    event_labels,
    find_events,
    onset_column,
    read_events,
    spans,
)
from firstcontact.recording.settings import HIGHEST_RATE, LOWEST_RATE, check_rate
from firstcontact.recording.table import Table
from firstcontact.recording.untrusted import library_errors, listed, quote

#: Latest time, s: 300 years, at which a stamp still resolves microseconds.
LATEST = 1e10


@dataclass(frozen=True, slots=True, eq=False)
class Stream:
    """Contents of one XDF stream.

    ``rate`` is the stated rate, Hz, 0 for irregular streams. ``stamps`` are the samples' times, s,
    and ``values`` the numbers or texts, shape (samples, channels). ``labels`` and ``units`` are
    texts about each channel. ``is_closed`` is False if the recording did not end properly.
    """

    name: str
    rate: float
    labels: tuple[str, ...]
    units: tuple[str, ...]
    stamps: NDArray[np.float64]
    values: NDArray[Any]
    is_closed: bool

    @property
    def is_text(self) -> bool:
        return self.values.dtype.kind == "U"

    @property
    def is_regular(self) -> bool:
        """True if the stream has numbers at a regular rate."""
        return not self.is_text and self.rate >= LOWEST_SIGNAL and len(self.stamps) > 1


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Samples of all signals in a time span without a gap.

    ``run`` has the times of the vibration's samples.
    """

    signals: Signals
    run: Run


def import_xdf(
    path: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    events: Path | None = None,
    channels: Path | None = None,
) -> Dataset:
    """Import pinches from an XDF file, one around each contact.

    ``events`` is a table of contacts, by default the file's markers. ``channels`` is a table that
    names the signals, by default all streams of numbers. ``sensor`` is the type of vibration
    sensor if there is no such table. ``rate`` is not used, because the file states it.
    """
    if channels is not None and sensor is not None:
        raise FileError(f"{channels} already states the sensor: leave --sensor out")
    streams = read_xdf(path)
    signals = _guess_signals(path, streams, sensor) if channels is None else read_signals(channels)
    notes = [
        f"stream {s.name}: its recording did not end properly, so samples may be missing at the end"
        for s in streams.values()
        if not s.is_closed
    ]
    empty = [s.name for s in streams.values() if not len(s.stamps)]
    if empty:
        notes.append(f"streams without samples were left out: {listed(empty)}")
    irregular = [
        s.name for s in streams.values() if not s.is_text and not s.is_regular and len(s.stamps)
    ]
    if irregular:
        notes.append(
            f"streams of numbers without a regular rate of {LOWEST_SIGNAL:g} Hz or more were left "
            f"out: {listed(irregular)}; if they mark contacts, give the times with --events"
        )
    parts, vibration = _unbroken_parts(path, streams, signals, notes)
    table = (
        _marker_table(path, streams, vibration, notes) if events is None else read_events(events)
    )
    lengths = [len(part.signals.data) for part in parts]
    if table is None:
        notes.append(NO_CONTACTS)
        given = Table(path, {"session": [path.stem] * len(parts)}, range(len(parts)), "part")
        places = [(k, 0, length) for k, length in enumerate(lengths)]
    else:
        rows, local = _find_parts(table, parts, vibration, notes)
        shapes, rates = [(n, 1) for n in lengths], [part.run.rate for part in parts]
        contacts = find_events(local, rows, [path] * len(parts), shapes, rates)
        starts, stops = spans(contacts, lengths, parts[0].signals.layout.rate)
        given, left_out = event_labels(local, contacts, starts)
        given.setdefault("session", [path.stem] * len(contacts))
        notes += left_out
        places = list(zip([event.file for event in contacts], starts, stops, strict=True))
    return cut_pinches(given, [part.signals for part in parts], places, notes)


def read_xdf(path: Path) -> dict[str, Stream]:
    """Read all streams of an XDF file by name, with times on one clock."""
    complaints = BufferingHandler(1 << 20)  # of pyxdf, about damage
    complaints.setLevel(logging.ERROR)
    log = logging.getLogger("pyxdf")
    before = log.handlers, log.propagate
    # The library does not close a file that it refuses.
    with library_errors(path, "XDF", "copy or record it again"), open_regular(path) as file:
        import pyxdf

        log.handlers, log.propagate = [complaints], False
        try:
            # Stamps are smoothed later, when gaps are known.
            loaded, _ = pyxdf.load_xdf(file, dejitter_timestamps=False, verbose=None)
        finally:
            log.handlers, log.propagate = before
        if complaints.buffer:
            raise ValueError(complaints.buffer[0].getMessage())
        streams = [_stream(stream) for stream in loaded]
        streams = _with_names(streams)
        for stream in streams:
            if not 0 <= stream.rate <= HIGHEST_RATE:
                raise ValueError(f"stream {quote(stream.name)} states {stream.rate:g} Hz")
            for sample in np.flatnonzero(~(np.abs(stream.stamps) <= LATEST)):
                stamp = f"{stream.stamps[sample]:g} s at sample {sample}"
                raise ValueError(f"stream {quote(stream.name)} has the time stamp {stamp}")
    return {stream.name: stream for stream in streams}


def _with_names(streams: Sequence[Stream]) -> list[Stream]:
    """Make the names of streams distinct: append numbers to equal names.

    A stream without samples, such as a crashed sender leaves, does not count as having a name.
    """
    streams = sorted(streams, key=lambda s: not len(s.stamps))
    filled = Counter(s.name for s in streams if len(s.stamps))
    seen: Counter[str] = Counter()
    named = []
    for stream in streams:
        seen[stream.name] += 1
        number = seen[stream.name]
        is_alone = number == 1 and filled[stream.name] <= 1
        named.append(stream if is_alone else replace(stream, name=f"{stream.name} #{number}"))
    return named


def _stream(stream: Mapping[str, Any]) -> Stream:
    info, values = stream["info"], stream["time_series"]
    if isinstance(values, list):
        texts = [" ".join(map(str, row)) for row in values]
        values = np.array(texts, dtype=np.str_).reshape(-1, 1)
    return Stream(
        info["name"][0] or "",
        float(info["nominal_srate"][0]),
        tuple(_channel_field(info, k, "label") for k in range(values.shape[1])),
        tuple(_channel_field(info, k, "unit") for k in range(values.shape[1])),
        np.asarray(stream["time_stamps"], dtype=np.float64),
        values,
        "footer" in stream,
    )


def _channel_field(info: Mapping[str, Any], channel: int, field: str) -> str:
    """Return a field, such as "unit", from a stream's XDF header; "" if it is missing.

    ``info`` is the header, and ``channel`` the index of the channel.
    """
    try:
        return str(info["desc"][0]["channels"][0]["channel"][channel][field][0] or "")
    except (KeyError, IndexError, TypeError):
        return ""


def _guess_signals(
    path: Path, streams: Mapping[str, Stream], sensor: VibrationSensor | None
) -> list[Signal]:
    """Return the signals of a file without a table of channels.

    The fast stream is the vibration. The other streams of numbers are further signals. Raises
    FileError unless exactly one stream is fast and has one channel.
    """
    numbers = [s for s in streams.values() if s.is_regular]
    fastest = max((s.rate for s in numbers), default=0.0)
    fast = [s for s in numbers if s.rate >= max(LOWEST_RATE, fastest / 2)]
    if len(fast) != 1 or fast[0].values.shape[1] > 1:
        kind = f"{len(fast)} streams of numbers at {LOWEST_RATE:g} Hz or more"
        if len(fast) == 1:
            kind = f"a stream {quote(fast[0].name)} of {fast[0].values.shape[1]} channels"
        raise FileError(
            f"{path} has {kind} ({listed(list(streams))}): name the vibration stream in a CSV file "
            "for --channels"
        )
    others = [Signal(s.name) for s in numbers if s is not fast[0]]
    return [Signal(fast[0].name, sensor=sensor or VibrationSensor.PIEZO), *others]


def _unbroken_parts(
    path: Path, streams: Mapping[str, Stream], signals: Sequence[Signal], notes: list[str]
) -> tuple[list[Part], Run]:
    """Return the time spans in which no signal has a gap, and the vibration's whole time span.

    Append sentences about gaps to ``notes``.
    """
    used = {signal.variable: _find_stream(path, streams, signal) for signal in signals}
    origins = {name: f"{path}: stream {quote(name)}" for name in used}
    main = next(used[signal.variable] for signal in signals if signal.sensor is not None)
    check_rate(f"{path}: the rate of stream {quote(main.name)}", main.rate)
    runs = {name: even_runs(origins[name], s.stamps, s.rate) for name, s in used.items()}
    samples = [
        select_samples(origins[s.name], _with_unit(signal, s), s.rate, s.values, s.labels)
        for signal, s in ((signal, used[signal.variable]) for signal in signals)
    ]
    whole = common = runs.pop(main.name)
    if len(whole) > 1:
        notes.append(f"stream {main.name} has {len(whole) - 1} gaps: nothing is joined across them")
    for others in runs.values():
        common = overlaps(common, others)
    if not common:
        raise FileError(
            f"{path}: the streams have no time in common: remove from the table of channels each "
            "stream that was recorded at another time"
        )
    left = sum(r.end - r.first for r in whole) - sum(r.end - r.first for r in common)
    if left:
        notes.append(
            f"{left / whole[0].rate:.3g} s of {main.name} are left out: another stream has no "
            "samples there"
        )
    nearest = {name: Nearest(others) for name, others in runs.items()}
    parts = []
    for run in common:
        rows: dict[str, slice | NDArray[np.int64]] = {main.name: slice(run.first, run.end)}
        for name, stream in nearest.items():
            rows[name] = stream.samples(run.times(used[name].rate / main.rate))
        cut = [replace(s, values=s.values[rows[s.signal.variable]]) for s in samples]
        parts.append(Part(combine(str(path), cut), run))
    return parts, Run(whole[0].first, whole[-1].end, whole[0].begin, whole[-1].last)


def _with_unit(signal: Signal, stream: Stream) -> Signal:
    """Return the signal with a unit: its own, or else the one that its stream states."""
    column = signal.column or 0
    is_known = signal.unit or column >= len(stream.units)
    return signal if is_known else replace(signal, unit=stream.units[column])


def _find_stream(path: Path, streams: Mapping[str, Stream], signal: Signal) -> Stream:
    """Return the stream of a signal. Raise FileError unless it has numbers at a regular rate."""
    stream = streams.get(signal.variable)
    if stream is None:
        raise FileError(
            f"{path} has no stream {quote(signal.variable)} (it has {listed(list(streams))}): "
            "correct the table of channels"
        )
    if signal.rate is not None:  # measured rates are better than those that senders state
        stream = replace(stream, rate=signal.rate)
    if not stream.is_regular:
        raise FileError(
            f"{path}: stream {quote(stream.name)} has no numbers at a regular rate of "
            f"{LOWEST_SIGNAL:g} Hz or more: leave it out of the table of channels, or give its "
            "measured rate there as 'rate_hz'"
        )
    return stream


def _marker_table(
    path: Path, streams: Mapping[str, Stream], vibration: Run, notes: list[str]
) -> Table | None:
    """Return the only stream of texts as a table of contacts; None without such a stream.

    Raises FileError if there are several such streams.
    """
    texts = [s for s in streams.values() if s.is_text and len(s.stamps)]
    if len(texts) > 1:
        raise FileError(
            f"{path} has several marker streams ({listed([s.name for s in texts])}), and any "
            "may mark the contacts: list the contacts in a table, and give it with --events"
        )
    if not texts:
        return None
    (stream,) = texts
    count = len(stream.stamps)
    notes.append(f"contacts are the {counted(count, 'marker')} of stream {stream.name}")
    seconds = {SECONDS: (stream.stamps - vibration.begin).tolist()}
    table = Table(path, seconds, range(1, count + 1), "marker")
    return add_labels(table, list(map(str, stream.values[:, 0])))


def _find_parts(
    table: Table, parts: Sequence[Part], vibration: Run, notes: list[str]
) -> tuple[list[int | None], Table]:
    """Find the part (time span without a gap) in which each contact of a table lies.

    Return a list with the index of each row's part, None if the contact lies in a gap. Also return
    the table, with times that count from the beginning of the part.
    """
    name = onset_column(table)

    def bounds(run: Run) -> tuple[float, float]:
        if name == SECONDS:
            return run.begin - vibration.begin, run.last - vibration.begin
        return run.first, run.end - 1

    places = [bounds(part.run) for part in parts]
    rows: list[int | None] = []
    local: list[float] = []
    for row, at in enumerate(table.parsed(name, parse_number)):
        place = next((k for k, (first, last) in enumerate(places) if first <= at <= last), None)
        if place is None and not 0 <= at <= bounds(vibration)[1]:
            raise table.refusal(name, row, "where the vibration has no samples")
        rows.append(place)
        local.append(at if place is None else at - places[place][0])
    left = rows.count(None)
    if left == len(rows):
        raise FileError(
            f"{table.path}: each of its {left} contacts lies in a gap, or where another stream has "
            "no samples: record the streams together, or leave one out of the table of channels"
        )
    if left:
        notes.append(
            f"{left} of {len(rows)} contacts lie in a gap, or where another stream has no samples: "
            "they are left out"
        )
    return rows, table.with_columns({name: local})


XDF = Importer(
    "xdf",
    "an .xdf file",
    import_xdf,
    suffixes=(".xdf",),
    options=("sensor", "events", "channels"),
    extra="files",
    modules=("pyxdf",),
)
