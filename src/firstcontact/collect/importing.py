"""Import of data in other file formats, which are written as recordings."""

from __future__ import annotations

import logging
from collections.abc import Collection
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np

from firstcontact.contact.finder import find_onsets
from firstcontact.core import (
    ArgumentError,
    ChannelKind,
    Dataset,
    FileError,
    InputError,
    VibrationSensor,
)
from firstcontact.core.files import AnyPath, given_path, resolved, temporary_path
from firstcontact.core.installation import require_extra
from firstcontact.core.plausible import clock_column_warning, same_signal_warning
from firstcontact.recording import IMPORTERS, Header, Importer, write_dataset
from firstcontact.recording.dataset import pinches_by_session

_log = logging.getLogger("firstcontact.recording")

#: Number of pinches whose channels are compared.
MOST_COMPARED = 20


def import_recordings(
    path: AnyPath,
    out: AnyPath,
    *,
    rate: float | None = None,
    source: str | None = None,
    sensor: str | None = None,
    events: AnyPath | None = None,
    channels: AnyPath | None = None,
    labels: AnyPath | None = None,
    find: bool = False,
) -> Dataset:
    """Convert sensor data in other file formats into recordings (.mcap files).

    Parameters
    ----------
    path
        File or folder: WAV, FLAC, XDF, MATLAB, HDF5, NPZ, CSV, or a format that a plug-in reads.
    out
        Folder for the recordings; it must be empty or new.
    rate
        Sampling rate, Hz, for a format that does not store it.
    source
        Origin of the data, "real", "twin" (simulated) or "synthetic", for a format that does not
        store it.
    sensor
        "piezo", "accelerometer", "microphone" or "hydrophone", for a format that does not store it.
    events, channels, labels
        Paths of CSV tables: ``events`` lists the contacts in long files (columns file, onset_s and
        labels), ``channels`` names the signals, and ``labels`` labels the files (columns file,
        object, shore_a, session and others). ``labels.csv`` in the folder is read by default.
    find
        True to detect the contacts in WAV and FLAC files, and cut out one pinch for each.

    Returns
    -------
    Dataset
        Pinches in the new recordings, in the order in which :func:`load` returns them: session by
        session, in the order of the sessions' first pinches. ``notes`` lists every assumption.

    Raises
    ------
    InputError
        The input cannot be used, or ``out`` is not empty. Nothing is written then.

    Examples
    --------
    >>> import numpy as np
    >>> import firstcontact as fc
    >>> rng = np.random.default_rng(0)
    >>> signals = rng.normal(0, 0.002, (4, 3000, 2))  # shape (pinches, samples, fingers)
    >>> labels = {"shore_a": [10.0, 10.0, 60.0, 60.0]}
    >>> np.savez("taps.npz", piezo=signals, piezo_unit="V", sample_rate_hz=4936.0, **labels)
    >>> data = fc.import_recordings("taps.npz", "imported", source="synthetic")
    >>> len(data), data.source
    (4, 'synthetic')
    """
    if sensor is not None and sensor not in tuple(VibrationSensor):
        raise ArgumentError(
            f"{sensor!r} is not a vibration sensor: choose one of {', '.join(VibrationSensor)}",
            parameter="sensor",
        )
    path, out = given_path(path), resolved(given_path(out, "out"))
    try:
        if out.exists() and (not out.is_dir() or any(out.iterdir())):
            raise FileError(
                f"{out} exists and is not an empty folder: choose another folder, or load the "
                "recordings in it"
            )
    except OSError as error:
        raise _unwritable(out, error) from error
    named = {"events": events, "channels": channels, "labels": labels}
    tables = {name: Path(table) for name, table in named.items() if table is not None}
    importer = find_importer(path, rate, tables)
    if sensor is not None and "sensor" not in importer.options:
        raise ArgumentError(f"{path} already states the sensor: do not give it", parameter="sensor")
    if find and "find" not in importer.options:
        raise ArgumentError(
            f"{path} is not a sound file: contacts are detected only in sound", parameter="find"
        )
    require_extra(importer)
    given = {
        "sensor": sensor and VibrationSensor(sensor),
        "find": find_onsets if find else None,
        **dict.fromkeys(named),
        **tables,
    }
    options = {name: value for name, value in given.items() if name in importer.options}
    _log.info("importing %s as %s", path, importer.name)
    with IMPORTERS.convert_errors(importer.name):
        dataset = importer.read(path, rate, **options)
        if not isinstance(dataset, Dataset):
            raise TypeError(f"{type(dataset).__name__} is not a Dataset: return one")
    dataset = _set_source(_add_warnings(dataset), path, source)
    first = dataset.pinches[0]
    name = path.name.encode("utf-8", "replace").decode()
    header = Header(
        first.layout,
        dataset.source,
        str(first.data.dtype),
        notes="\n".join((f"imported from {name}", *dataset.notes)),
        session_assumed=dataset.sessions_assumed,
    )
    try:
        with temporary_path(out) as temporary:
            temporary.mkdir()
            write_dataset(dataset, temporary, header)
            temporary.replace(out)  # fails if the folder is not empty any more
    except OSError as error:
        raise _unwritable(out, error) from error
    except InputError as error:
        # The writer's message names a temporary file that no longer exists.
        if isinstance(error.__cause__, OSError):
            raise _unwritable(out, error.__cause__) from error
        raise
    written = chain.from_iterable(pinches_by_session(dataset).values())
    return replace(dataset, pinches=tuple(written))


def _add_warnings(dataset: Dataset) -> Dataset:
    """Add warnings to a dataset if a vibration looks like a clock, or two look the same."""
    columns = dataset.layout.columns(ChannelKind.VIBRATION)
    names = [dataset.layout.column_names[column] for column in columns]
    parts = [pinch.data[:, columns] for pinch in dataset.pinches[:MOST_COMPARED]]
    doubts = filter(
        None,
        (clock_column_warning(names, parts), same_signal_warning(names, np.concatenate(parts))),
    )
    return replace(dataset, notes=(*dataset.notes, *(f"warning: {doubt}" for doubt in doubts)))


def find_importer(path: Path, rate: float | None = None, tables: Collection[str] = ()) -> Importer:
    """Return the first importer that accepts a path, a rate and tables.

    ``rate`` is the user's sampling rate, Hz. ``tables`` are the names of the user's tables, such as
    "events". Raises InputError, which lists what is accepted, if there is no such importer.
    """
    if not path.exists():
        raise FileError(f"{path} does not exist: check the path")
    importer = None
    for name in IMPORTERS:  # plug-ins after the first that accepts the path are not imported
        with IMPORTERS.convert_errors(name):
            if IMPORTERS[name].accepts(path, tables):
                importer = IMPORTERS[name]
                break
    if importer is None and tables:
        options = " and ".join(tables)
        able = [i.title for i in IMPORTERS.values() if set(tables) <= set(i.options)]
        remedy = f"give {' or '.join(able)}, or leave {options} out" if able else "leave one out"
        raise FileError(f"{path} cannot be imported with a table of {options}: {remedy}")
    if importer is None and path.is_dir():
        if not any(path.iterdir()):
            raise FileError(f"{path} is an empty folder: check the path")
        importer = next((i for i in IMPORTERS.values() if i.marker is not None), None)
    if rate is not None and (importer is None or "rate" not in importer.options):
        titles = " or ".join(i.title for i in IMPORTERS.values() if "rate" in i.options)
        raise ArgumentError(
            f"{path} already states the rate: give it only for {titles}", parameter="rate"
        )
    if importer is None:
        if path.suffix == ".mcap":
            raise FileError(f"{path} is already a recording: use it without importing it")
        *first, last = (i.title for i in IMPORTERS.values())
        raise FileError(f"{path} has an unknown format: give {', '.join(first)}, or {last}")
    return importer


def _set_source(dataset: Dataset, path: Path, source: str | None) -> Dataset:
    """Set the source (origin) of a dataset to the one that its file or the user states.

    ``source`` is the one that the user states, or None. Raises ArgumentError if the file states
    another one. If neither states one, add a note.
    """
    if source is not None and dataset.source not in ("unknown", source):
        raise ArgumentError(
            f"{path} states {dataset.source!r}, not {source!r}: leave it out or correct the file",
            parameter="source",
        )
    dataset = replace(dataset, source=source or dataset.source)
    if dataset.source != "unknown":
        return dataset
    note = "the source of the data is unknown: state it as real, twin or synthetic (`source`)"
    return replace(dataset, notes=(*dataset.notes, note))


def _unwritable(out: Path, error: OSError) -> InputError:
    return FileError(f"{out} cannot be written ({error.strerror}): check the folder and its disk")
