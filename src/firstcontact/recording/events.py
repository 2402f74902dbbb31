"""Import long WAV files with a table of the contacts in them, as pinches around each contact.

The table is a CSV with a row a contact: ``onset_s`` (seconds from the start of the file) or
``onset_sample`` (from 0), ``file`` where there are several, ``channel`` (from 0) where one
channel of each is wanted, and any of the labels of :mod:`firstcontact.recording._labels`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, InputError, VibrationSensor
from firstcontact.core.files import files_below
from firstcontact.recording import _cells as cells
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS, labelled
from firstcontact.recording.checks import FileSettings, make_layout
from firstcontact.recording.formats import Importer
from firstcontact.recording.quoting import listed, shown
from firstcontact.recording.table import read_columns
from firstcontact.recording.wav import FULL_SCALE, check_alike, read_wav, source_of, wav_samples

#: What is cut out around a contact, s: quiet that a detector measures its noise in, and a
#: window with what filters look ahead. Between two that are closer it is shared out alike.
BEFORE, AFTER = 0.080, 0.060
SECONDS, SAMPLE = "onset_s", "onset_sample"
_FINGER = "first_finger"
_CHANNEL = "channel"
_KNOWN = {"file", _CHANNEL, SECONDS, SAMPLE, _FINGER, "source", "comment", *LABEL_COLUMNS}

Columns = dict[str, list[str]]


@dataclass(frozen=True, slots=True)
class _Event:
    """A contact: row of the table, number of its file, its channel if one is named, its sample."""

    row: int
    file: int
    channel: int | None
    sample: int


def import_events(
    path: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    events: Path | None = None,
) -> Dataset:
    """Pinches around the contacts in a long WAV file, or in those of a folder.

    Parameters
    ----------
    path
        The file, or a folder with the files that the table names, there or below.
    rate
        Not asked for: the files say it.
    sensor
        What was recorded with; a microphone unless said otherwise.
    events
        The table.

    Raises
    ------
    InputError
        Names the table and the row, or the file, that cannot be used.
    """
    if events is None:
        raise InputError(f"{path} needs a table of its contacts: give it with --events")
    columns = read_columns(events)
    for name in CONTACT_COLUMNS:
        if name in columns and name != _FINGER:
            raise InputError(
                f"{events} has {name}, which counts within a pinch: give the time of each contact "
                f"in {SECONDS} or its sample in {SAMPLE}"
            )
    files, of_rows, notes = _files(path, events, columns.get("file"))
    sounds = [read_wav(file) for file in files]
    one = _CHANNEL in columns
    check_alike(files, [(rate, data[:, :1] if one else data) for rate, data in sounds])
    rate, first = sounds[0]
    found = _events(events, columns, of_rows, files, [data.shape for _, data in sounds], rate)
    whole = [wav_samples(file, data) for file, (_, data) in zip(files, sounds, strict=True)]
    cuts, starts = _cut(found, whole, rate)
    given = {
        name: [cell[event.row] for event in found]
        for name, cell in columns.items()
        if name in (*LABEL_COLUMNS, _FINGER)
    }
    if "session" not in given:
        given["session"] = [files[event.file].stem for event in found]
        notes.append("sessions are not said: each WAV file was taken as one")
    given["first_contact"] = [
        str(event.sample - start) for event, start in zip(found, starts, strict=True)
    ]
    unknown = sorted(set(columns) - _KNOWN)
    if unknown:
        notes.append(f"{events.name}: columns not known and left out: {listed(unknown)}")
    source = source_of(events, columns)
    what = sensor or VibrationSensor.MICROPHONE
    settings = FileSettings(what, float(rate), "full scale", 1.0, source, None)
    layout = make_layout(settings, cuts[0].shape[1], scale=1.0 / FULL_SCALE[str(first.dtype)])
    return labelled(str(events), cuts, layout, given, source, notes)


def _files(
    path: Path, table: Path, names: list[str] | None
) -> tuple[list[Path], list[int | None], list[str]]:
    """Files that have contacts, number of each row's (None: of a file not asked for), notes."""
    if not path.is_dir():
        if names is None:
            return [path], [], []
        mine: list[int | None] = [0 if name.strip() == path.name else None for name in names]
        if 0 not in mine:
            raise InputError(f"{table}: no row has file {path.name!r}: correct its column file")
        others = mine.count(None)
        return [path], mine, [f"{others} contacts are in other files"] if others else []
    if names is None:
        raise InputError(f"{table} has no column file: name the WAV file of each row")
    by_name: dict[str, list[Path]] = {}
    there = files_below(path, ".wav")
    for file in there:
        for name in {file.name, file.relative_to(path).as_posix()}:
            by_name.setdefault(name, []).append(file)
    files: list[Path] = []
    rows: list[int | None] = []
    for row, name in enumerate(names):
        found = by_name.get(name.strip(), [])
        if len(found) != 1:
            what = "is in two folders" if found else "is not in the folder"
            raise InputError(
                f"{table}: file of row {row} is {shown(name)}, which {what} {path}: correct the "
                "row or the folder"
            )
        if found[0] not in files:
            files.append(found[0])
        rows.append(files.index(found[0]))
    left = len(there) - len(files)
    return files, rows, [f"{left} WAV files have no contact in {table.name}"] if left else []


def _events(
    table: Path,
    columns: Columns,
    of_rows: Sequence[int | None],
    files: Sequence[Path],
    shapes: Sequence[tuple[int, ...]],
    rate: float,
) -> list[_Event]:
    """The contacts in the order of the rows."""
    given = [name for name in (SECONDS, SAMPLE) if name in columns]
    if len(given) != 1:
        raise InputError(
            f"{table} has {' and '.join(given) or f'neither {SECONDS} nor {SAMPLE}'}: give the "
            f"time of each contact in {SECONDS} or its sample in {SAMPLE}"
        )
    (name,) = given
    of = cells.each(str(table), columns, _CHANNEL, cells.whole)
    out = []
    for row, cell in enumerate(columns[name]):
        file = of_rows[row] if of_rows else 0
        if file is None:
            continue
        try:
            value = cells.number(cell)
        except ValueError as error:
            raise InputError(
                f"{table}: {name} of row {row} is {shown(cell)}, {error}: correct it"
            ) from None
        at = value * rate if name == SECONDS else value
        end, channels = shapes[file]
        if of is not None and not 0 <= of[row] < channels:
            raise InputError(
                f"{table}: channel of row {row} is {shown(of[row])}, and {files[file].name} has "
                f"{channels}: count from 0"
            )
        if not 0 <= at <= end - 1:
            last = f"{(end - 1) / rate:g} s" if name == SECONDS else end - 1
            raise InputError(
                f"{table}: {name} of row {row} is {shown(cell)}, outside {files[file].name} "
                f"(0 to {last}): correct the row"
            )
        if name == SAMPLE and at != int(at):
            raise InputError(
                f"{table}: {name} of row {row} is {shown(cell)}, which is not a whole number: "
                f"give samples, or seconds in {SECONDS}"
            )
        out.append(_Event(row, file, None if of is None else of[row], round(at)))
    for one, other in pairwise(sorted(out, key=_place)):
        if (one.file, one.sample) == (other.file, other.sample):
            raise InputError(
                f"{table}: rows {one.row} and {other.row} are one contact, at sample {one.sample} "
                f"of {files[one.file].name}: remove one"
            )
    return out


def _place(event: _Event) -> tuple[int, int]:
    return event.file, event.sample


def _cut(
    events: Sequence[_Event], whole: Sequence[NDArray[Any]], rate: float
) -> tuple[list[NDArray[Any]], list[int]]:
    """Samples around each contact, shape (samples, channels), and where they start."""
    before, after = round(BEFORE * rate), round(AFTER * rate)
    starts = [max(0, event.sample - before) for event in events]
    stops = [min(len(whole[e.file]), e.sample + after) for e in events]
    for one, other in pairwise(sorted(range(len(events)), key=lambda i: _place(events[i]))):
        if events[one].file == events[other].file:
            border = _border(events[one].sample, events[other].sample)
            stops[one] = min(stops[one], border)
            starts[other] = max(starts[other], border)
    cuts = []
    for event, start, stop in zip(events, starts, stops, strict=True):
        wanted = slice(None) if event.channel is None else slice(event.channel, event.channel + 1)
        cuts.append(np.ascontiguousarray(whole[event.file][start:stop, wanted]))
    return cuts, starts


def _border(one: int, other: int) -> int:
    """Where the cut of a contact ends and that of the next one begins, behind the former."""
    return min(other, one + max(1, round((other - one) * AFTER / (BEFORE + AFTER))))


EVENTS = Importer(
    "events",
    "a .wav file or a folder of them with --events",
    import_events,
    suffixes=(".wav",),
    asks_sensor=True,
    asks_events=True,
)
