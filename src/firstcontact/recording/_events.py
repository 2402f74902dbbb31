"""Importer of long sound files as pinches around contacts from a table or label track.

Without a table, a file becomes one pinch without known contacts, for `firstcontact label`.
"""

from __future__ import annotations

from pathlib import Path

from firstcontact.core import Dataset, InputError, VibrationSensor
from firstcontact.recording._event_table import (
    AFTER,
    BEFORE,
    CHANNEL,
    Columns,
    cut_events,
    event_labels,
    find_events,
    read_event_table,
)
from firstcontact.recording._file_rows import files_by_name
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import labelled
from firstcontact.recording._quoting import quote
from firstcontact.recording._sound import SUFFIXES, read_sound
from firstcontact.recording._table_columns import stated_source
from firstcontact.recording._wav import check_alike, sound_layout, wav_samples

#: Note about a file without a table of contacts.
NO_CONTACTS = "no contacts are known: give --events, or mark them with `firstcontact label`"

__all__ = ["AFTER", "BEFORE", "EVENTS", "import_events"]


def import_events(
    path: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    events: Path | None = None,
) -> Dataset:
    """Import pinches around the contacts in a long WAV or FLAC file, or in a folder of files."""
    if events is None:
        return _as_one(path, sensor)
    columns = read_event_table(events)
    files, of_rows, notes = _files(path, events, columns)
    sounds = [read_sound(file) for file in files]
    one = CHANNEL in columns
    check_alike(files, [(rate, data[:, :1] if one else data) for rate, data in sounds])
    rate, first = sounds[0]
    shapes = [data.shape for _, data in sounds]
    contacts = find_events(events, columns, of_rows, files, shapes, [rate] * len(files))
    signals = [wav_samples(file, data) for file, (_, data) in zip(files, sounds, strict=True)]
    cuts, starts = cut_events(contacts, signals, rate)
    given, left_out = event_labels(events, columns, contacts, starts)
    if "session" not in given:
        given["session"] = [files[event.file].stem for event in contacts]
        notes.append("the table names no sessions: each sound file was taken as one")
    source = stated_source(events, columns)
    layout = sound_layout(sensor, rate, cuts[0].shape[1], first.dtype)
    return labelled(str(events), cuts, layout, given, source, [*notes, *left_out])


def _as_one(file: Path, sensor: VibrationSensor | None) -> Dataset:
    rate, data = read_sound(file)
    check_alike([file], [(rate, data)])
    signal = wav_samples(file, data)
    layout = sound_layout(sensor, rate, signal.shape[1], data.dtype)
    return labelled(str(file), [signal], layout, {"session": [file.stem]}, "unknown", [NO_CONTACTS])


def _files(
    path: Path, table: Path, columns: Columns
) -> tuple[list[Path], list[int | None], list[str]]:
    """Return the files with contacts, the file number of each row (None: unused), and notes."""
    names = columns.get("file")
    if not path.is_dir():
        if names is None:
            return [path], [], []
        mine: list[int | None] = [0 if name.strip() == path.name else None for name in names]
        if 0 not in mine:
            raise InputError(f"{table}: no row is for {path.name!r}: correct the column 'file'")
        foreign = mine.count(None)
        return (
            [path],
            mine,
            [f"{foreign} contacts of the table are in other files"] if foreign else [],
        )
    if names is None:
        raise InputError(
            f"{table} has no column 'file': add it, with the name of the sound file of each row"
        )
    sound_files, by_name = files_by_name(path, *SUFFIXES)
    files: dict[Path, int] = {}
    rows: list[int | None] = []
    for row, name in enumerate(names):
        matches = by_name.get(name.strip(), [])
        if len(matches) != 1:
            fault = "is in two folders" if matches else "is not in the folder"
            raise InputError(
                f"{table}: 'file' of {columns.place(row)} is {quote(name)}, which {fault} {path}: "
                "correct the row or the folder"
            )
        rows.append(files.setdefault(matches[0], len(files)))
    left = len(sound_files) - len(files)
    return (
        list(files),
        rows,
        [f"{left} sound files have no contact in {table.name}"] if left else [],
    )


EVENTS = Importer(
    "events",
    "a .wav or .flac file, or a folder of them with --events",
    import_events,
    suffixes=SUFFIXES,
    asks_sensor=True,
    asks_events=True,
)
