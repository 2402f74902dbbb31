"""Importers of pinches from named arrays in HDF5 files and NumPy archives.

The page docs/how-to/import-recordings.md lists the names and shapes. Exported files have an
attribute ``firstcontact_layout``, which replaces all other settings but ``source``.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Dataset, FileError, VibrationSensor
from firstcontact.core.files import open_regular
from firstcontact.core.installation import require_modules
from firstcontact.core.layout import TAXELS
from firstcontact.core.plausible import clock_column_warning, gravity_unit_warning
from firstcontact.core.text import counted
from firstcontact.recording._formats import Importer
from firstcontact.recording._labels import PINCH_COLUMNS, make_dataset, note_unknown
from firstcontact.recording.messages import SOURCES
from firstcontact.recording.settings import (
    LAYOUT,
    SETTINGS,
    check_samples,
    check_vibration,
    find_sensor,
    joined,
    make_layout,
    read_layout,
    read_settings,
)
from firstcontact.recording.table import Table
from firstcontact.recording.untrusted import library_errors, one_of

Arrays = Mapping[str, NDArray[Any]]

#: Shapes of the arrays of slower sensors, without pinches and samples.
SHAPES = {"force": (2, TAXELS), "strip": (2,)}
#: All names that have a meaning.
NAMES = {*VibrationSensor, *SHAPES, *SETTINGS, LAYOUT, *PINCH_COLUMNS}
#: Shortest pinch, s. Shorter ones are probably samples of a column.
_SHORTEST = 0.003


def import_hdf5(path: Path, rate: float | None = None) -> Dataset:
    """Import pinches from an HDF5 file. ``rate`` is ignored, because the file states the rate."""
    return from_arrays(path, *read_hdf5(path, NAMES, (*SETTINGS, LAYOUT)))


def import_npz(path: Path, rate: float | None = None) -> Dataset:
    """Import pinches from a NumPy archive. ``rate`` is ignored: the file states the rate."""
    arrays = {}
    remedy = "save it with numpy.savez and without objects"
    with library_errors(path, "an NPZ of plain arrays", remedy), open_regular(path) as stream:
        archive = np.load(stream, allow_pickle=False)
        for name in NAMES.intersection(archive.files):
            with library_errors(f"{path}: '{name}'", "a plain array", remedy):
                arrays[name] = archive[name]
                if not isinstance(arrays[name], np.ndarray):
                    raise ValueError("it is not in NumPy's format")
                if arrays[name].dtype.kind == "U":
                    arrays[name].tolist()  # raises an error for invalid characters
        return from_arrays(path, arrays, sorted(set(archive.files) - NAMES))


def read_hdf5(
    path: Path, names: Collection[str], settings: Collection[str] = ()
) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Read the datasets ``names`` and the attributes ``settings`` of an HDF5 file.

    Return a dict of the arrays that exist, by name, and a list of the names of all other datasets.
    """
    require_modules("files", "h5py")
    with library_errors(path, "HDF5", "write it again"):
        open_regular(path).close()
        import h5py

        arrays: dict[str, NDArray[Any]] = {}
        with h5py.File(path, "r") as file:
            for name in (wanted := [name for name in file if name in names]):
                if not isinstance(file.get(name, getlink=True), h5py.HardLink):
                    raise FileError(f"{path}: '{name}' is a link: copy the data into the file")
                if not isinstance(dataset := file[name], h5py.Dataset):
                    continue
                if dataset.external or dataset.is_virtual:
                    raise FileError(f"{path}: '{name}' lies in another file: copy it into this one")
                if dataset.dtype.hasobject and h5py.check_string_dtype(dataset.dtype) is None:
                    raise FileError(
                        f"{path}: '{name}' contains neither numbers nor texts: remove it, or save "
                        "a MATLAB file with -v7"
                    )
                arrays[name] = np.asarray(dataset[()])
            for holder in (file, *map(file.get, VibrationSensor)):
                for name in settings if holder is not None else ():
                    if name in holder.attrs:
                        arrays[name] = np.asarray(holder.attrs[name])
            return arrays, sorted(set(file) - set(wanted))


def from_arrays(path: Path, arrays: Arrays, unknown: Sequence[str] = ()) -> Dataset:
    """Make a dataset from arrays, with the names and shapes that the import page lists.

    ``path`` is the file that error messages name. ``unknown`` are the names of unused arrays in the
    file, for the dataset's notes. Raises FileError, which names the array, for an invalid array.
    """
    remedy = "array 'piezo': add it, shape (pinches, samples, 1 or 2)"
    sensor = find_sensor(str(path), arrays, remedy)
    given = {name: _single(path, arrays, name) for name in (*SETTINGS, LAYOUT) if name in arrays}
    pinches, samples = arrays[sensor].shape[:2] if arrays[sensor].ndim > 1 else (0, 0)
    signals = {}
    for name in (sensor, *SHAPES):
        if name not in arrays:
            continue
        values = arrays[name]
        if name == sensor:
            wanted = "(pinches, samples, 1 or 2), or for vectors (pinches, samples, 1 or 2, axes)"
            is_right = values.ndim in (3, 4) and values.shape[2] in (1, 2)
        else:
            wanted = str((pinches, samples, *SHAPES[name]))
            is_right = values.shape == (pinches, samples, *SHAPES[name])
        if not is_right:
            raise FileError(
                f"{path}: the array '{name}' has the shape {values.shape}: change it to {wanted}"
            )
        origin = f"{path}: {name}"
        if name == sensor:
            values = check_vibration(origin, values, list(values))
        else:
            values = check_samples(origin, values)
        signals[name] = values.reshape(pinches * samples, *values.shape[2:])
    given_labels = [name for name in PINCH_COLUMNS if name in arrays]
    wrong = next((name for name in given_labels if arrays[name].shape != (pinches,)), None)
    if wrong is not None:
        raise FileError(
            f"{path}: the array '{wrong}' has the shape {arrays[wrong].shape}, but '{sensor}' has "
            f"{pinches} pinches of {samples} samples: give one value for each pinch, or transpose "
            f"'{sensor}'"
        )
    bounds = [(start, start + samples) for start in range(0, pinches * samples, samples)]
    labels = {name: list(arrays[name]) for name in given_labels}
    table = Table(path, labels, range(pinches), "pinch")
    notes = note_unknown(table, {*arrays, *unknown} - NAMES, "arrays")
    dataset = from_signals(table, signals, bounds, given, notes)
    if samples < _SHORTEST * dataset.layout.rate:
        raise FileError(
            f"{path}: the array '{sensor}' has {counted(pinches, 'pinch')} of "
            f"{counted(samples, 'sample')}, which is shorter than {1000 * _SHORTEST:g} ms: "
            "transpose it, so that each row is one pinch"
        )
    return dataset


def from_signals(
    table: Table,
    signals: Arrays,
    bounds: Sequence[tuple[int, int]],
    given: Mapping[str, Any],
    notes: Sequence[str],
) -> Dataset:
    """Make a dataset from the signals of all pinches, one after the other.

    ``table`` has the labels, one row per pinch. ``signals`` are arrays by name, the vibration
    first, shape (samples of all pinches, ...). ``bounds`` are the first sample and the end of each
    pinch in them. ``given`` are the settings of the file, such as the sampling rate.
    """
    origin, (sensor, vibration) = str(table.path), next(iter(signals.items()))
    data = joined([values.reshape(len(values), -1) for values in signals.values()])
    exported = LAYOUT in given
    if exported:
        layout = read_layout(origin, given[LAYOUT])
        if layout.width != data.shape[1]:
            raise FileError(
                f"{origin}: the signals have {data.shape[1]} columns, but '{LAYOUT}' has "
                f"{layout.width}: export the recording again"
            )
    else:
        force = signals.get("force", np.zeros(0))
        settings = read_settings(origin, given, VibrationSensor(sensor), vibration, force)
        layout = make_layout(
            settings,
            vibration.shape[1],
            axes=vibration.shape[2] if vibration.ndim > 2 else 1,
            force="force" in signals,
            strip="strip" in signals,
        )
        if doubt := clock_column_warning(layout.column_names, [data[a:b] for a, b in bounds]):
            raise FileError(f"{origin}: {doubt}")
        axes = tuple(range(layout.vibration[0].axes))
        doubt = gravity_unit_warning(sensor, layout.physical(data, axes), layout.vibration[0].unit)
        notes = [*notes, *([f"warning: {origin}: {doubt}"] if doubt else [])]
    return make_dataset(
        table,
        [data[start:stop] for start, stop in bounds],
        layout,
        source=one_of(origin, "source", given.get("source", "unknown"), SOURCES),
        notes=notes,
        exported=exported,
    )


def _single(path: Path, arrays: Arrays, name: str) -> Any:
    values = arrays[name]
    if values.size != 1:
        raise FileError(
            f"{path}: the array '{name}' has the shape {values.shape}: give a single value"
        )
    return values.reshape(-1)[0]


HDF5 = Importer(
    "hdf5",
    "a .h5 or .hdf5 file",
    import_hdf5,
    suffixes=(".h5", ".hdf5"),
    extra="files",
    modules=("h5py",),
)
NPZ = Importer("npz", "a .npz file", import_npz, suffixes=(".npz",))
