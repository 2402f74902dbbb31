"""Importers of pinches from arrays in HDF5 and NPZ files.

The arrays and their shapes are:

- ``piezo``: (pinches, samples, 1 or 2);
- ``force``, optional: (pinches, samples, 2, 6);
- ``strip``, optional: (pinches, samples, 2);
- with one value per pinch: ``first_contact``, ``second_contact``, ``motor_start`` (-1 if unknown),
  ``first_finger``, ``object``, ``shore_a`` or ``hardness_rank``, ``specimen``, ``session``,
  ``role``.

The file or its ``piezo`` has the attributes ``sample_rate_hz``, ``piezo_unit``, and optionally
``force_unit``, ``smoothing_alpha`` and ``source``. In an NPZ, attributes are 0-d arrays. The
attribute ``firstcontact_layout`` of exported files replaces all of them but ``source``.

Other sensors use their own name instead of piezo: ``accelerometer``, ``microphone`` or
``hydrophone``. Vectors have the shape (pinches, samples, 1 or 2, axes). The attribute ``axis`` is
the number of the axis that detectors use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from firstcontact.core import TAXELS, Dataset, InputError, VibrationSensor, counted
from firstcontact.recording._checks import (
    LAYOUT,
    SETTINGS,
    check_force,
    check_samples,
    check_vibration,
    find_sensor,
    joined,
    make_layout,
    read_settings,
)
from firstcontact.recording._formats import Importer
from firstcontact.recording._hdf5 import read_hdf5
from firstcontact.recording._labels import CONTACT_COLUMNS, LABEL_COLUMNS, labelled
from firstcontact.recording._npz import read_npz
from firstcontact.recording._table_columns import unknown_columns

_SHAPES = {"force": (2, TAXELS), "strip": (2,)}
_KNOWN = {*VibrationSensor, *_SHAPES, *SETTINGS, *LABEL_COLUMNS, *CONTACT_COLUMNS}
#: Shortest pinch, s. Shorter ones are probably samples of a column.
_SHORTEST = 0.003

Arrays = Mapping[str, NDArray[Any]]


def import_hdf5(path: Path, rate: float | None = None) -> Dataset:
    """Import pinches from an HDF5 file. The file states its rate, so ``rate`` is ignored."""
    return from_arrays(path, *read_hdf5(path, _KNOWN, (*SETTINGS, LAYOUT)))


def import_npz(path: Path, rate: float | None = None) -> Dataset:
    """Import pinches from a NumPy archive. The file states its rate, so ``rate`` is ignored."""
    return from_arrays(path, *read_npz(path, _KNOWN))


def from_arrays(path: Path, arrays: Arrays, unknown: Sequence[str] = ()) -> Dataset:
    """Build pinches from named arrays of an HDF5 file or NumPy archive.

    Parameters
    ----------
    path
        Path of the file, for messages.
    arrays
        Arrays with names that this module knows.
    unknown
        Names of other arrays in the file, for the notes.

    Raises
    ------
    InputError
        An array is invalid; the message names it.
    """
    sensor = find_sensor(
        str(path), arrays, "array 'piezo': add it, shape (pinches, samples, 1 or 2)"
    )
    given = {name: _one(path, arrays, name) for name in (*SETTINGS, LAYOUT) if name in arrays}
    settings = read_settings(str(path), given, sensor)
    data = _signals(path, arrays, sensor)
    if "force" in arrays and settings.layout is None:
        check_force(f"{path}: force", arrays["force"], settings.force_unit)
    pinches, samples, width = data.shape
    if samples < _SHORTEST * settings.rate:
        raise InputError(
            f"{path}: the array '{sensor}' has {counted(pinches, 'pinch')} of "
            f"{counted(samples, 'sample')}, which is shorter than {1000 * _SHORTEST:g} ms: "
            "transpose it, so that each row is one pinch"
        )
    sensors, *axes = arrays[sensor].shape[2:]
    layout = settings.layout or make_layout(
        settings,
        sensors,
        axes=axes[0] if axes else 1,
        force="force" in arrays,
        strip="strip" in arrays,
    )
    if layout.width != width:
        raise InputError(
            f"{path}: the arrays have {width} columns, but '{LAYOUT}' has {layout.width}: export "
            "the recording again"
        )
    columns = {
        name: list(_per_pinch(path, name, arrays[name], pinches))
        for name in (*LABEL_COLUMNS, *CONTACT_COLUMNS)
        if name in arrays
    }
    notes = [*settings.notes, *unknown_columns(path, (*arrays, *unknown), arrays, "arrays")]
    exported = settings.layout is not None
    return labelled(
        str(path), list(data), layout, columns, settings.source, notes, exported=exported
    )


def _signals(path: Path, arrays: Arrays, sensor: VibrationSensor) -> NDArray[Any]:
    """Return the columns of all arrays side by side, shape (pinches, samples, columns)."""
    parts = []
    shape: tuple[int, ...] = ()
    for name in (sensor, *_SHAPES):
        if name not in arrays:
            continue
        values = arrays[name]
        if name == sensor:
            wanted = "(pinches, samples, 1 or 2), or for vectors (pinches, samples, 1 or 2, axes)"
            right = values.ndim in (3, 4) and values.shape[2] in (1, 2)
        else:
            wanted = f"(pinches, samples, {', '.join(map(str, _SHAPES[name]))})"
            right = values.shape[2:] == _SHAPES[name]
        if not right or (shape and values.shape[:2] != shape):
            raise InputError(
                f"{path}: the array '{name}' has the shape {values.shape} and must have {wanted}"
                + (f" with {shape[0]} pinches of {shape[1]} samples, as {sensor}" if shape else "")
            )
        shape = values.shape[:2]
        check = check_vibration if name == sensor else check_samples
        checked = check(f"{path}: {name}", values)
        parts.append(checked.reshape(*shape, -1))
    return joined(parts)


def _per_pinch(path: Path, name: str, values: NDArray[Any], pinches: int) -> NDArray[Any]:
    if values.shape != (pinches,):
        raise InputError(
            f"{path}: the array '{name}' has the shape {values.shape}, but there are {pinches} "
            "pinches: give one value for each"
        )
    return values


def _one(path: Path, arrays: Arrays, name: str) -> Any:
    values = arrays[name]
    if values.size != 1:
        raise InputError(
            f"{path}: the array '{name}' has the shape {values.shape}: give a single value"
        )
    return values.reshape(-1)[0]


HDF5 = Importer("hdf5", "a .h5 or .hdf5 file", import_hdf5, suffixes=(".h5", ".hdf5"))
NPZ = Importer("npz", "a .npz file", import_npz, suffixes=(".npz",))
