"""Importer of MATLAB files of any version: arrays of pinches, or signals that a table describes.

Without a table, a file holds the arrays of :mod:`firstcontact.recording._arrays`. With a table of
channels, each file is one pinch, with signals of any name and rate.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, FileError, VibrationSensor
from firstcontact.core.files import file_in, files_below, open_regular
from firstcontact.recording._arrays import NAMES, SHAPES, from_arrays, read_hdf5
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import note_unknown
from firstcontact.recording._signals import (
    ALL,
    Signal,
    Signals,
    combine,
    cut_pinches,
    read_signals,
    select_samples,
)
from firstcontact.recording.sound import LABELS
from firstcontact.recording.table import Table, is_file, match_each_file, read_columns
from firstcontact.recording.untrusted import library_errors, listed

#: Smallest character code that is no character.
_SURROGATES = 0xD800
_SUFFIX = ".mat"
_TEXTS = ("source", "force_unit", *(f"{sensor}_unit" for sensor in VibrationSensor))
#: Start of a file of version 7.3, which is HDF5 after 512 bytes.
_HDF5 = b"MATLAB 7.3"

Arrays = dict[str, NDArray[Any]]


def import_mat(
    path: Path, rate: float | None = None, channels: Path | None = None, labels: Path | None = None
) -> Dataset:
    """Import pinches from a MATLAB file, or one pinch from each file of a folder.

    ``channels`` is a table that names the signals. ``labels`` is a table with a row per file. Both
    are CSV files.
    """
    if channels is None:
        if labels is not None or path.is_dir():
            raise FileError(
                f"{path} needs a CSV file that describes its signals: give it with --channels"
            )
        return _import_named(path)
    signals = read_signals(channels)
    lacking = next((s.variable for s in signals if s.rate is None), None)
    if lacking is not None:
        raise FileError(
            f"{channels} has no 'rate_hz' of {listed([lacking])}: add it, because MATLAB files do "
            "not state it"
        )
    files, table = _files(path, labels)
    notes: list[str] = []
    pinches = [_read_signals(file, signals, notes) for file in files]
    for file, pinch in zip(files, pinches, strict=True):
        if pinch.layout != pinches[0].layout:
            raise FileError(
                f"{file} and {files[0].name} have different signals: import them separately"
            )
    notes += note_unknown(table, table)
    places = [(k, 0, len(pinch.data)) for k, pinch in enumerate(pinches)]
    return cut_pinches(table, pinches, places, notes)


def _files(path: Path, labels: Path | None) -> tuple[list[Path], Table]:
    origin = labels or file_in(path if path.is_dir() else path.parent, LABELS)
    if labels is None and not (path.is_dir() and origin.exists()):
        files = files_below(path, _SUFFIX) if path.is_dir() else [path]
        if not files:
            raise FileError(f"{path} holds no {_SUFFIX} files: give the folder that does")
        return files, Table(path, {}, range(len(files)), "file")
    table = read_columns(origin, "file")
    if path.is_dir():
        return match_each_file(path, table, _SUFFIX), table
    rows = [row for row, name in enumerate(table.get("file", ())) if is_file(name, path)]
    if len(rows) != 1:
        raise FileError(
            f"{origin}: {len(rows)} rows name {path.name} in the column 'file': name it in one row"
        )
    return [path], table.of_rows(rows)


def _read_signals(file: Path, signals: list[Signal], notes: list[str]) -> Signals:
    """Read from one file the ``signals`` that a table of channels describes.

    Append a note about all other variables to ``notes``.
    """
    arrays, unread = read_mat(file, {s.variable for s in signals})
    parts = []
    for signal in signals:
        name = signal.variable
        if name not in arrays:
            raise FileError(
                f"{file} has no variable {name!r} (it has {listed(unread) or 'no others'}): "
                "correct the table of channels"
            )
        values = np.atleast_2d(arrays[name].squeeze())  # Simulink stores 1 x 1 x samples
        if values.ndim != 2:
            raise FileError(
                f"{file}: {name} has the shape {values.shape}, but a signal must be a matrix with "
                "a column for each channel: save one variable for each pinch or finger"
            )
        if signal.column == ALL:
            values, signal = values.reshape(-1, 1, order="F"), replace(signal, column=None)
        elif values.shape[0] < values.shape[1]:  # time runs along the longer side
            values = values.T
        parts.append(select_samples(f"{file}: {name}", signal, signal.rate or 0.0, values))
    left = f"variables that the table of channels does not name were left out: {listed(unread)}"
    if unread and left not in notes:
        notes.append(left)
    return combine(str(file), parts)


def _import_named(path: Path) -> Dataset:
    """Import a MATLAB file whose variables have the names in ``NAMES``."""
    arrays, unread = read_mat(path, NAMES)
    if not any(name in arrays for name in VibrationSensor):
        raise FileError(
            f"{path} has no array 'piezo': add it, shape (pinches, samples, 1 or 2), or describe "
            f"its variables ({listed(unread) or 'it has none'}) with --channels"
        )
    for name, values in arrays.items():
        if name in _TEXTS and values.dtype.kind in "iu":  # version 7.3 stores character codes
            codes = values.reshape(-1).tolist()
            is_text = all(0 < code < _SURROGATES for code in codes)
            arrays[name] = np.array("".join(map(chr, codes)) if is_text else "")
        elif name in set(VibrationSensor) and values.ndim == 2:
            arrays[name] = values[:, :, None]
        elif name not in {*VibrationSensor, *SHAPES} and 1 in values.shape:
            arrays[name] = values.reshape(-1)
    return from_arrays(path, arrays, unread)


def read_mat(path: Path, names: Collection[str]) -> tuple[Arrays, list[str]]:
    """Read the variables ``names`` from a MATLAB file.

    Return a dict of the variables that exist, by name, and a list of the names of all others.
    """
    with library_errors(path, "a MATLAB file", "save it again"), open_regular(path) as stream:
        if stream.read(len(_HDF5)) == _HDF5:
            arrays, unread = read_hdf5(path, names)
            return {name: values.T for name, values in arrays.items()}, unread
        from scipy.io import loadmat, whosmat

        stream.seek(0)
        stored = [name for name, _, _ in whosmat(stream)]
        wanted = [name for name in stored if name in names]
        stream.seek(0)
        loaded = loadmat(stream, variable_names=wanted)
        arrays = {name: _plain_array(path, name, loaded[name]) for name in wanted}
        return arrays, sorted(set(stored) - set(names))


def _plain_array(path: Path, name: str, values: Any) -> NDArray[Any]:
    """Return the numbers or texts of the variable ``name`` as an array.

    A cell array of single values becomes an array of these values. Raises FileError for another
    type.
    """
    array = np.asarray(values)
    if array.dtype == object:
        cells = [np.asarray(cell) for cell in array.reshape(-1)]
        if all(c.dtype.kind in "iufU" and c.size <= 1 for c in cells):
            return np.array([c.reshape(-1)[0] if c.size else "" for c in cells], object)
    if array.dtype.kind not in "iufbU":
        raise FileError(
            f"{path}: the variable '{name}' holds neither numbers nor texts: save numbers or texts"
        )
    return array


MAT = Importer(
    "mat", "a .mat file", import_mat, suffixes=(_SUFFIX,), options=("channels", "labels")
)
