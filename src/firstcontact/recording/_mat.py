"""Importer of MATLAB files: arrays of pinches, or signals that a table describes.

Without a table, a file holds the arrays of :mod:`firstcontact.recording._arrays`. With a table of
channels, each file is one pinch, with signals of any name and rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, InputError, VibrationSensor, files_below
from firstcontact.recording._arrays import from_arrays
from firstcontact.recording._channel_table import Signal, read_signals
from firstcontact.recording._checks import SETTINGS
from firstcontact.recording._file_rows import files_of_rows
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS
from firstcontact.recording._mat_file import read_mat, text_of_codes
from firstcontact.recording._quoting import listed
from firstcontact.recording._signals import Assembled, Taken, assemble, checked, cut_pinches
from firstcontact.recording._table import read_columns
from firstcontact.recording._table_columns import stated_source, unknown_columns
from firstcontact.recording._wav import LABELS

_SUFFIX = ".mat"
_TEXTS = ("source", "force_unit", *(f"{sensor}_unit" for sensor in VibrationSensor))
_ARRAYS = (*VibrationSensor, "force", "strip")
_KNOWN = {"file", "source", "comment", *LABEL_COLUMNS, *CONTACT_COLUMNS}
_NAMED = {*_ARRAYS, *SETTINGS, *LABEL_COLUMNS, *CONTACT_COLUMNS}


def import_mat(
    path: Path,
    rate: float | None = None,
    channels: Path | None = None,
    labels: Path | None = None,
) -> Dataset:
    """Import pinches from a MATLAB file, or one pinch from each file of a folder."""
    if channels is None:
        if labels is not None or path.is_dir():
            raise InputError(
                f"{path} needs a CSV file that describes its signals: give it with --channels"
            )
        return _from_named(path)
    signals = read_signals(channels)
    lacking = next((s.variable for s in signals if s.rate is None), None)
    if lacking is not None:
        name = listed([lacking])
        raise InputError(
            f"{channels} has no 'rate_hz' of {name}: add it, because MATLAB files do not state it"
        )
    files, columns, table = _files(path, labels)
    notes: list[str] = []
    assembled = [_signals(file, signals, notes) for file in files]
    for file, recording in zip(files, assembled, strict=True):
        if recording.layout != assembled[0].layout:
            raise InputError(
                f"{file} and {files[0].name} have different signals: import them separately"
            )
    source = stated_source(table, columns)
    notes += unknown_columns(table, columns, _KNOWN)
    places = [(k, 0, len(recording.data)) for k, recording in enumerate(assembled)]
    return cut_pinches(table, assembled, places, columns, source, notes)


def _files(path: Path, labels: Path | None) -> tuple[list[Path], Mapping[str, list[str]], Path]:
    """Return the files, the columns of the table of labels, and the path of that table."""
    table = labels or (path if path.is_dir() else path.parent) / LABELS
    if labels is None and not (path.is_dir() and table.exists()):
        if not path.is_dir():
            return [path], {}, path
        files = files_below(path, _SUFFIX)
        if not files:
            raise InputError(f"{path} holds no {_SUFFIX} files: give the folder that does")
        return files, {}, path
    columns = read_columns(table)
    if "file" not in columns:
        raise InputError(
            f"{table} has no column 'file': add it, with the name of the MATLAB file of each row"
        )
    if path.is_dir():
        return files_of_rows(path, columns["file"], table, _SUFFIX), columns, table
    rows = [row for row, name in enumerate(columns["file"]) if name.strip() == path.name]
    if len(rows) != 1:
        raise InputError(f"{table} has {len(rows)} rows for {path.name}: give one row")
    row = {name: [cells[rows[0]]] for name, cells in columns.items()}
    return [path], columns.of_rows(row, rows), table


def _signals(file: Path, signals: list[Signal], notes: list[str]) -> Assembled:
    """Return the signals of one file that the table of channels names."""
    arrays, unread = read_mat(file, {s.variable for s in signals})
    taken = []
    for signal in signals:
        name = signal.variable
        if name not in arrays:
            raise InputError(
                f"{file} has no variable {name!r} (it has {listed(unread) or 'no others'}): "
                "correct the table of channels"
            )
        values = checked(f"{file}: {name}", signal, _in_time(file, signal, arrays[name]))
        width = values.shape[1]
        names = (name,) if width == 1 else tuple(f"{name}_{k}" for k in range(width))
        if signal.column is not None:
            names = (f"{name}_{signal.column}",)
        assert signal.rate is not None
        taken.append(Taken(signal, signal.rate, values, names))
    left = f"variables that the table of channels does not name were left out: {listed(unread)}"
    if unread and left not in notes:
        notes.append(left)
    return assemble(str(file), taken)


def _in_time(file: Path, signal: Signal, values: NDArray[Any]) -> NDArray[Any]:
    """Return a variable with time along the first axis, shape (samples, columns)."""
    if values.ndim != 2:
        raise InputError(
            f"{file}: {signal.variable} has the shape {values.shape}, but a signal must be a "
            "matrix: correct the variable, or the table of channels"
        )
    if signal.sensor is not None and signal.column is None:
        return values.reshape(-1, 1, order="F")
    return values if values.shape[0] >= values.shape[1] else values.T


def _from_named(path: Path) -> Dataset:
    """Return the dataset of a file whose arrays have our names."""
    arrays, unread = read_mat(path, _NAMED)
    if not any(name in arrays for name in VibrationSensor):
        raise InputError(
            f"{path} has no array 'piezo': add it, shape (pinches, samples, 1 or 2), or describe "
            f"its variables ({listed(unread) or 'it has none'}) with --channels"
        )
    for name in _TEXTS:
        if name in arrays and arrays[name].dtype.kind in "iu":
            arrays[name] = np.array(text_of_codes(arrays[name]))
    for name, values in arrays.items():
        if name in set(VibrationSensor) and values.ndim == 2:
            arrays[name] = values[:, :, None]
        elif name not in _ARRAYS and 1 in values.shape:
            arrays[name] = values.reshape(-1)
    return from_arrays(path, arrays, unread)


MAT = Importer(
    "mat",
    "a .mat file",
    import_mat,
    suffixes=(_SUFFIX,),
    asks_channels=True,
    asks_labels=True,
)
