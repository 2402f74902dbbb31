"""Importer of a folder of WAV files with a ``labels.csv``."""

from __future__ import annotations

import struct
import warnings
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, InputError, Layout, VibrationSensor, counted, read_regular
from firstcontact.recording._checks import FileSettings, check_rate, check_vibration, make_layout
from firstcontact.recording._file_rows import files_of_rows
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS, labelled
from firstcontact.recording._quoting import reason
from firstcontact.recording._table import read_columns
from firstcontact.recording._table_columns import stated_source, unknown_columns

LABELS = "labels.csv"
_KNOWN = {"file", "sample_rate_hz", "source", "comment", *LABEL_COLUMNS, *CONTACT_COLUMNS}
#: Largest file, bytes, as limited by the format's length fields.
LONGEST = (1 << 32) - 1
#: Errors of SciPy for a damaged file.
_DAMAGE = (
    OSError,
    ValueError,
    EOFError,
    ArithmeticError,
    NameError,
    TypeError,
    KeyError,
    IndexError,
    MemoryError,
    struct.error,
    UserWarning,  # base class of SciPy's warnings
)
#: Start of a "fmt " chunk in file order, and codes of encodings with whole-byte samples.
_FORMAT = "HHIIHH"
_UNPACKED = (1, 3, 0xFFFE)
#: SciPy's types of WAV samples, with full scale in raw steps.
FULL_SCALE = {"uint8": 128.0, "int16": 2.0**15, "int32": 2.0**31, "float32": 1.0, "float64": 1.0}


def import_wav(
    folder: Path,
    rate: float | None = None,
    sensor: VibrationSensor | None = None,
    labels: Path | None = None,
) -> Dataset:
    """Import every WAV file below a folder as one pinch, labelled by ``labels.csv``."""
    table = labels or folder / LABELS
    if labels is None and not table.exists():
        raise InputError(
            f"{folder} has no {LABELS}: add it, name a table of labels elsewhere with --labels, or "
            "a table of the contacts in long files with --events"
        )
    columns = read_columns(table)
    if "file" not in columns:
        raise InputError(
            f"{table} has no column 'file': add it, with the name of the WAV file of each row"
        )
    files = files_of_rows(folder, columns["file"], table, ".wav")
    sounds = [read_wav(file) for file in files]
    rate, first = sounds[0]
    check_alike(files, sounds)
    for row, cell in enumerate(columns.get("sample_rate_hz", [])):
        if check_rate(f"{table}: sample_rate_hz of {columns.place(row)}", cell) != rate:
            raise InputError(
                f"{table}: 'sample_rate_hz' of {files[row].name} is {cell}, but the file has "
                f"{rate} Hz: correct the table"
            )
    notes = unknown_columns(table, columns, _KNOWN)
    source = stated_source(table, columns)
    layout = sound_layout(sensor, rate, first.shape[1], first.dtype)
    cuts = [wav_samples(file, data) for file, (_, data) in zip(files, sounds, strict=True)]
    return labelled(str(table), cuts, layout, columns, source, notes)


def sound_layout(
    sensor: VibrationSensor | None, rate: float, channels: int, dtype: np.dtype[Any]
) -> Layout:
    """Return the layout of a sound file's channels."""
    sensor_kind = sensor or VibrationSensor.MICROPHONE
    settings = FileSettings(sensor_kind, float(rate), "full scale", 1.0, "unknown", None)
    return make_layout(settings, channels, scale=1.0 / FULL_SCALE[str(dtype)])


def check_alike(files: Sequence[Path], sounds: Sequence[tuple[int, NDArray[Any]]]) -> None:
    """Raise an error if files differ in rate, type or channels, or have impossible ones."""
    rate, first = sounds[0]
    for file, (other, data) in zip(files, sounds, strict=True):
        if not 1 <= data.shape[1] <= 2:
            raise InputError(
                f"{file} has {data.shape[1]} channels, but only one, or two of index finger and "
                "thumb, can be imported: choose one in the column 'channel' of a table of "
                "contacts (--events)"
            )
        if other != rate:
            raise InputError(
                f"{file} is sampled at {other} Hz, {files[0].name} at {rate} Hz: import them in "
                "separate commands"
            )
        if (data.dtype, data.shape[1]) != (first.dtype, first.shape[1]):
            raise InputError(
                f"{file} has {counted(data.shape[1], 'channel')} of {data.dtype}, {files[0].name} "
                f"has {first.shape[1]} of {first.dtype}: convert one, import them separately, or "
                "choose one channel in the column 'channel' of a table of contacts (--events)"
            )
    check_rate(f"{files[0]}: the sample rate", rate)


def read_wav(file: Path) -> tuple[int, NDArray[Any]]:
    """Return the rate in Hz and the samples as stored in the file, shape (samples, channels)."""
    from scipy.io import wavfile

    try:
        # Reading from memory: for files, the library allocates the size that a header declares.
        data = BytesIO(read_regular(file, LONGEST))
        _check_chunks(file, data)
        with warnings.catch_warnings():
            warnings.simplefilter("error", wavfile.WavFileWarning)
            warnings.filterwarnings("ignore", "Chunk .* not understood", wavfile.WavFileWarning)
            rate, values = wavfile.read(data)
    except InputError:
        raise
    except _DAMAGE as error:
        raise InputError(
            f"{file} cannot be read as WAV ({reason(error).rstrip('.')}): convert it to PCM WAV"
        ) from error
    if values.ndim == 1:
        values = values[:, None]
    if str(values.dtype) not in FULL_SCALE:
        raise InputError(f"{file} holds {values.dtype}: convert it to PCM WAV of at most 32 bits")
    if not len(values):
        raise InputError(f"{file} holds no samples: remove it and its row")
    return int(rate), values


def _check_chunks(file: Path, data: BytesIO) -> None:
    """Raise an error if numbers of the header contradict each other, or the file is truncated."""
    order = ">" if data.read(4) == b"RIFX" else "<"
    data.seek(12)
    while len(head := data.read(8)) == 8:
        kind, size = struct.unpack(order + "4sI", head)
        start = data.tell()
        available = len(data.getbuffer()) - start
        if kind == b"data" and size > available:
            raise InputError(
                f"{file} declares {size} bytes of samples but holds {available}: copy it again"
            )
        if kind == b"fmt " and min(size, available) >= struct.calcsize(order + _FORMAT):
            format_chunk = data.read(struct.calcsize(order + _FORMAT))
            _check_format(file, *struct.unpack(order + _FORMAT, format_chunk))
        data.seek(start + size + size % 2)
    data.seek(0)


def _check_format(
    file: Path, form: int, channels: int, rate: int, speed: int, frame: int, bits: int
) -> None:
    """Raise an error for header numbers that contradict each other."""
    if form not in _UNPACKED:
        return
    if frame != channels * -(-bits // 8):
        raise InputError(
            f"{file} has a header with {counted(channels, 'channel')} of {bits} bits and "
            f"{counted(frame, 'byte')} a frame, which contradict each other: write it again as "
            "PCM WAV"
        )
    if speed != rate * frame:
        raise InputError(
            f"{file} has a header with {rate} frames of {counted(frame, 'byte')} a second and "
            f"{speed} bytes a second, which contradict each other: write it again as PCM WAV"
        )


def wav_samples(file: Path, data: NDArray[Any]) -> NDArray[Any]:
    """Return samples around 0 in a type that recordings store."""
    if data.dtype == np.uint8:
        return data.astype(np.int16) - np.int16(128)
    if data.dtype.kind == "i":
        return data  # keeps the type of the file: all pinches have one type
    return check_vibration(f"{file}: the signal", data)


WAV = Importer(
    "wav",
    f"a folder of WAV files with {LABELS}",
    import_wav,
    marker=LABELS,
    asks_sensor=True,
    asks_labels=True,
)
