"""Importers of sound files: folders of short WAV files, and long files with several contacts."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import (
    ArgumentError,
    ChannelKind,
    Dataset,
    FileError,
    Layout,
    VibrationSensor,
)
from firstcontact.core.files import file_in, files_below, open_regular, read_regular
from firstcontact.core.installation import require_modules
from firstcontact.core.text import counted
from firstcontact.core.units import Unit
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import make_dataset, note_unknown
from firstcontact.recording.events import (
    AFTER,
    CHANNEL,
    NO_CONTACTS,
    Event,
    event_labels,
    find_events,
    read_events,
    spans,
)
from firstcontact.recording.settings import FileSettings, check_rate, check_vibration, make_layout
from firstcontact.recording.table import Table, is_file, match_each_file, match_files, read_columns
from firstcontact.recording.untrusted import library_errors

LABELS = "labels.csv"
SUFFIXES = (".wav", ".flac")
#: Largest WAV file, bytes, as limited by the format's length fields.
LONGEST = (1 << 32) - 1
#: Types of samples, with full scale in raw steps.
FULL_SCALE = {"int8": 128.0, "int16": 2.0**15, "int32": 2.0**31, "float32": 1.0, "float64": 1.0}

Sound = tuple[float, NDArray[Any]]
#: Function that returns the contacts found in signals, shape (samples, channels), of a rate in Hz.
Find = Callable[[NDArray[np.float64], float], Sequence[Any]]


def import_wav(
    folder: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    labels: Path | None = None,
    find: Find | None = None,
) -> Dataset:
    """Import the WAV files in a folder, each as one pinch or, with ``find``, one per contact.

    ``labels`` is a CSV table with a row per file. ``find`` detects contacts in a signal. ``sensor``
    is the type of sensor, by default a microphone. ``rate`` is not used.
    """
    path = labels or file_in(folder, LABELS)
    notes: list[str] = []
    if labels is None and not path.exists():
        files = files_below(folder, ".wav")
        if not files:
            raise FileError(f"{folder} holds no .wav file: check the path")
        table = Table(path, {"object": [file.stem for file in files]}, range(len(files)), "file")
        notes = [f"{folder.name} has no {LABELS}: the names of the files were taken as objects"]
    else:
        table = read_columns(path, "file")
        files = match_each_file(folder, table, ".wav")
    layout, signals = _shared_layout(files, [read_sound(file, notes) for file in files], sensor)
    for row, cell in enumerate(table.get("sample_rate_hz", [])):
        if check_rate(f"{path}: sample_rate_hz of {table.place(row)}", cell) != layout.rate:
            reason = f"but {files[row].name} has {layout.rate:g} Hz"
            raise table.refusal("sample_rate_hz", row, reason)
    notes += note_unknown(table, set(table) - {"sample_rate_hz"})
    return _make_pinches(table, files, signals, layout, find, notes)


def import_events(
    path: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    events: Path | None = None,
    find: Find | None = None,
) -> Dataset:
    """Import pinches around the contacts in a long WAV or FLAC file, or in a folder of files.

    The table ``events`` lists the contacts. Without it, ``find`` detects them, or else the file is
    one pinch. ``sensor`` is by default a microphone. ``rate`` is not used.
    """
    if events is None:
        notes: list[str] = []
        layout, signals = _shared_layout([path], [read_sound(path, notes)], sensor)
        table = Table(path, {"session": [path.stem]}, [0], "pinch")
        return _make_pinches(table, [path], signals, layout, find, notes)
    if find is not None:
        raise ArgumentError(
            f"{events} already lists the contacts: leave find out, or remove that file",
            parameter="find",
        )
    table = read_events(events)
    files, of_rows, notes = _match_rows(path, table)
    sounds = [read_sound(file, notes) for file in files]
    shapes = [data.shape for _, data in sounds]
    layout, signals = _shared_layout(files, sounds, sensor, is_chosen=CHANNEL in table)
    contacts = find_events(table, of_rows, files, shapes, [layout.rate] * len(files))
    starts, stops = spans(contacts, [len(data) for data in signals], layout.rate)
    cuts = []
    for event, start, stop in zip(contacts, starts, stops, strict=True):
        columns = slice(None) if event.channel is None else slice(event.channel, event.channel + 1)
        cuts.append(np.ascontiguousarray(signals[event.file][start:stop, columns]))
    given, left_out = event_labels(table, contacts, starts)
    if "session" not in given:
        given["session"] = [files[event.file].stem for event in contacts]
        notes.append("the table names no sessions: each sound file was taken as one")
    return make_dataset(given, cuts, layout, notes=[*notes, *left_out])


def _make_pinches(
    table: Table,
    files: Sequence[Path],
    signals: Sequence[NDArray[Any]],
    layout: Layout,
    find: Find | None,
    notes: list[str],
) -> Dataset:
    """Return a dataset with one pinch for each file or, with ``find``, for each detected contact.

    Append sentences about the contacts to ``notes``. Raise FileError if ``find`` detects no contact
    in a file.
    """
    if find is None:
        has_contacts = "first_contact" in table or "pre_trigger_samples" in table
        notes += [] if has_contacts else [NO_CONTACTS]
        return make_dataset(table, signals, layout, notes=notes)
    columns, merged = layout.columns(ChannelKind.VIBRATION), AFTER * layout.rate
    events: list[Event] = []
    for number, signal in enumerate(signals):
        for onset in find(layout.physical(signal, columns), layout.rate):
            last = events[-1] if events else None
            if last is None or last.file != number or onset.sample - last.sample > merged:
                events.append(Event(number, number, None, onset.sample))
    counts = [sum(event.file == number for event in events) for number in range(len(files))]
    if 0 in counts:
        raise FileError(
            f"{files[counts.index(0)]} has no contact that is clearly louder than its noise: leave "
            "it out, or list its contacts in a table of events"
        )
    starts, stops = spans(events, [len(signal) for signal in signals], layout.rate)
    cuts = [signals[e.file][a:b] for e, a, b in zip(events, starts, stops, strict=True)]
    each = " to ".join(map(str, sorted({min(counts), max(counts)})))
    notes.append(
        f"{counted(len(events), 'contact')} found in {counted(len(files), 'file')} "
        f"({each} a file); no person has confirmed them"
    )
    return make_dataset(table.of_rows([e.row for e in events]), cuts, layout, notes=notes)


def _match_rows(path: Path, table: Table) -> tuple[list[Path], Sequence[int | None], list[str]]:
    """Match the rows of a table of contacts with the sound files at ``path``.

    Return the files, the index of each row's file, and notes for the user. The index is None for a
    row about another file.
    """
    if path.is_dir():
        files, numbers, left = match_files(path, table, *SUFFIXES)
        note = f"{len(left)} sound files have no contact in {table.path.name}"
        return files, numbers, [note] if left else []
    names = table.get("file", [path.name] * len(table.numbers))
    rows = [0 if is_file(name, path) else None for name in names]
    if 0 not in rows:
        raise FileError(f"{table.path}: no row is for {path.name!r}: correct the column 'file'")
    others = rows.count(None)
    return [path], rows, [f"{others} contacts of the table are in other files"] if others else []


def _shared_layout(
    files: Sequence[Path],
    sounds: Sequence[Sound],
    sensor: VibrationSensor | None,
    *,
    is_chosen: bool = False,
) -> tuple[Layout, list[NDArray[Any]]]:
    """Return the layout that all files share, and the samples of each file in a type to store.

    ``is_chosen`` is True if a table states one channel for each contact. Raises FileError if files
    differ in rate, data type or number of channels.
    """
    rate, first = sounds[0]
    width = 1 if is_chosen else first.shape[1]
    for file, (other, data) in zip(files, sounds, strict=True):
        channels = 1 if is_chosen else data.shape[1]
        if not 1 <= channels <= 2:
            raise FileError(
                f"{file} has {channels} channels, but at most two (index finger and thumb) can be "
                "imported: choose one in the column 'channel' of a table of events"
            )
        if (other, data.dtype, channels) != (rate, first.dtype, width):
            raise FileError(
                f"{file} has {counted(channels, 'channel')} of {data.dtype} at {other:g} Hz, "
                f"but {files[0].name} has {width} of {first.dtype} at {rate:g} Hz: convert one, "
                "import them separately, or choose one channel in the column 'channel' of a table "
                "of events"
            )
    check_rate(f"{files[0]}: the sample rate", rate)
    kind = sensor or VibrationSensor.MICROPHONE
    settings = FileSettings(kind, rate, Unit("full scale"))
    layout = make_layout(settings, width, scale=1.0 / FULL_SCALE[str(first.dtype)])
    return layout, [_stored(file, data) for file, (_, data) in zip(files, sounds, strict=True)]


def _stored(file: Path, data: NDArray[Any]) -> NDArray[Any]:
    if data.dtype.kind == "i":  # keeps the type of the file: all pinches have one type
        return data.astype(np.int16) if data.dtype == np.int8 else data
    return check_vibration(f"{file}: the signal", data)


def read_sound(file: Path, notes: list[str] | None = None) -> Sound:
    """Read a WAV or FLAC file. Return its sampling rate, Hz, and its samples.

    The samples are signed integers or floats, shape (samples, channels). Append a note if the
    file's header states wrong lengths. Raises FileError if the file cannot be read.
    """
    if file.suffix.lower() == ".flac":
        require_modules("files", "soundfile")
        with library_errors(file, "FLAC", "copy it again, or convert it to WAV"):
            open_regular(file).close()
            rate, values = _decode(file)
    else:
        rate, values = _read_wav(file, [] if notes is None else notes)
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    if values.dtype == np.uint8:  # 8-bit samples are stored around 128
        values = (values ^ 128).view(np.int8)
    elif values.dtype == np.int8 or str(values.dtype) not in FULL_SCALE:
        raise FileError(
            f"{file} has samples of {values.dtype}: convert it to PCM WAV of at most 32 bits"
        )
    if not len(values):
        raise FileError(f"{file} holds no samples: leave it out")
    return float(rate), values.reshape(len(values), -1)


def _read_wav(file: Path, notes: list[str]) -> Sound:
    from scipy.io import wavfile

    with library_errors(file, "WAV", "convert it to PCM WAV"):
        data, note = _repair_header(read_regular(file, LONGEST))
        warnings.simplefilter("error", wavfile.WavFileWarning)
        warnings.filterwarnings("ignore", "Chunk .* not understood", wavfile.WavFileWarning)
        try:
            # From memory: for files, the library allocates the size that a header declares.
            sound: Sound = wavfile.read(BytesIO(data))
        except Exception as error:
            try:  # compressed samples
                sound = _decode(BytesIO(data))
            except Exception:
                raise error from None
        notes += [f"{file.name}: {note}"] if note else []
        return sound


def _repair_header(data: bytes) -> tuple[bytes, str]:
    """Correct the lengths in the header of a WAV file, which has the bytes ``data``.

    A program writes the lengths when it ends a file, so a killed program leaves wrong ones. Return
    the bytes of the corrected file, and a note for the user, "" if the lengths were right.
    """
    order = {b"RIFF": "<", b"RIFX": ">"}.get(data[:4])
    if order is None or data[8:12] != b"WAVE":
        return data, ""
    head, place, form, name, size = struct.Struct(f"{order}4sI"), 12, b"", b"", 0
    while name != b"data":
        if place + head.size > len(data):
            return data, ""
        name, size = head.unpack_from(data, place)
        place += head.size
        if name == b"fmt ":
            form = data[place : place + size]
        if name != b"data":
            # Some programs leave out the byte that makes a size even.
            place += size + (size % 2 and data[place + size : place + size + 1] == b"\0")
    frame = struct.unpack_from(f"{order}H", form, 12)[0] if len(form) >= 14 else 0
    if frame == 0:
        return data, ""
    left = len(data) - place
    real = left if size == 0 and not _are_chunks(data[place:], head) else min(size, left)
    real -= real % frame
    rest = data[place + real :].removeprefix(b"\0" * (real % 2))
    if size != real:
        note = f"the header states {size} bytes of samples, but the file has {real}: all were read"
    elif not _are_chunks(rest, head):
        note = f"{len(rest)} bytes after its samples were left out"
    elif not 0 <= len(data) - head.size - head.unpack_from(data)[1] <= 1:
        note = "the header states a wrong length of the file: all samples were read"
    else:
        return data, ""
    body = b"WAVE" + head.pack(b"fmt ", len(form)) + form + head.pack(b"data", real)
    return head.pack(data[:4], len(body) + real) + body + data[place : place + real], note


def _are_chunks(data: bytes, head: struct.Struct) -> bool:
    """Return True if the bytes are complete chunks (sections) of a WAV file.

    ``head`` is the format of the name and length before each chunk.
    """
    place = 0
    while place + head.size <= len(data):
        name, size = head.unpack_from(data, place)
        if not (name.isascii() and name.decode().isprintable()):
            return False
        place += head.size + size + size % 2
    return place in (len(data), len(data) + 1)


def _decode(file: Path | BytesIO) -> Sound:
    """Read a sound file by libsndfile. Return its rate, Hz, and the samples as an array."""
    import soundfile

    with soundfile.SoundFile(file) as sound:
        kinds = {"PCM_24": "int32", "PCM_32": "int32", "FLOAT": "float32", "DOUBLE": "float64"}
        values = sound.read(dtype=kinds.get(sound.subtype, "int16"), always_2d=True)
        if len(values) != sound.frames:
            raise ValueError(f"{len(values)} of {sound.frames} samples are left")
        return sound.samplerate, values


WAV = Importer(
    "wav",
    f"a folder of WAV files with {LABELS}",
    import_wav,
    marker=LABELS,
    options=("sensor", "labels", "find"),
)
EVENTS = Importer(
    "events",
    "a .wav or .flac file, or a folder of them with a table of events",
    import_events,
    suffixes=SUFFIXES,
    options=("sensor", "events", "find"),
)
