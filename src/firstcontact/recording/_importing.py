"""Import of data in other formats: choice of an importer, and atomic writing of recordings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

from firstcontact.core import (
    AnyPath,
    Dataset,
    InputError,
    VibrationSensor,
    given_path,
    require_extra,
    resolve_path,
    temporary_path,
)
from firstcontact.recording._dataset import pinches_by_session, write_dataset
from firstcontact.recording._formats import IMPORTERS, Importer
from firstcontact.recording._header import Header


def import_path(
    path: AnyPath,
    out: AnyPath,
    rate: float | None = None,
    source: str | None = None,
    sensor: VibrationSensor | None = None,
    events: AnyPath | None = None,
    channels: AnyPath | None = None,
    labels: AnyPath | None = None,
) -> Dataset:
    """Import a file or folder into a new folder of recordings.

    Parameters
    ----------
    path
        Path of the data.
    out
        Folder for the recordings, which must be missing or empty.
    rate
        Rate, Hz, for a file that does not state it.
    source
        Source, one of :data:`firstcontact.recording._header.SOURCES`, for a file that does not
        state it.
    sensor
        Sensor, for a file that does not state it.
    events
        Table of the contacts in long files.
    channels
        Table of a file's signals, for a file whose signals have other names than ours.
    labels
        Table of the labels of a folder's files, if it lies outside the folder.

    Returns
    -------
    Dataset
        The imported data, session by session as written. Its notes list assumptions.

    Raises
    ------
    InputError
        The data cannot be used or state another source, or ``out`` is not empty. Nothing was
        written.
    """
    path, out = given_path(path), resolve_path(given_path(out, "out"))
    try:
        if out.exists() and (not out.is_dir() or any(out.iterdir())):
            raise InputError(f"{out} exists and is not an empty folder: choose another --out")
    except OSError as error:
        raise _unwritable(out, error) from error
    named = {"events": events, "channels": channels, "labels": labels}
    tables = {name: None if table is None else Path(table) for name, table in named.items()}
    importer = find_importer(
        path, rate, [name for name, table in tables.items() if table is not None]
    )
    if sensor is not None and not importer.asks_sensor:
        raise InputError(f"{path} states its sensor: leave --sensor out")
    require_extra(importer)
    given: dict[str, object] = {
        name: value
        for name, value in {"sensor": sensor, **tables}.items()
        if getattr(importer, f"asks_{name}")
    }
    with IMPORTERS.calling(importer.name):
        dataset = importer.read(path, rate, **given)
        if not isinstance(dataset, Dataset):
            raise TypeError(f"{type(dataset).__name__} is not a Dataset")
    dataset = _with_source(dataset, path, source)
    first = dataset.pinches[0]
    name = path.name.encode("utf-8", "replace").decode()
    notes = "\n".join((f"imported from {name}", *dataset.notes))
    header = Header(
        first.layout,
        dataset.source,
        str(first.data.dtype),
        notes=notes,
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


def _with_source(dataset: Dataset, path: Path, source: str | None) -> Dataset:
    """Return the dataset with its source: the one that the file states, or else the user's."""
    if source is not None and dataset.source not in ("unknown", source):
        raise InputError(
            f"{path} states the source {dataset.source}, but --source is {source}: leave "
            "--source out, or correct the file"
        )
    dataset = replace(dataset, source=source or dataset.source)
    if dataset.source != "unknown":
        return dataset
    note = "the source of the data is unknown: import them with --source to state it"
    return replace(dataset, notes=(*dataset.notes, note))


def _unwritable(out: Path, error: OSError) -> InputError:
    return InputError(f"{out} cannot be written ({error.strerror}): check the folder and its disk")


def _accepting(path: Path, given: Sequence[str]) -> Importer | None:
    """Return the first importer that accepts a path. Plug-ins after it are not imported."""
    for name in IMPORTERS:
        with IMPORTERS.calling(name):
            if IMPORTERS[name].accepts(path, given):
                return IMPORTERS[name]
    return None


def find_importer(path: Path, rate: float | None = None, given: Sequence[str] = ()) -> Importer:
    """Return the first importer that accepts the path.

    If no importer accepts a folder, the first importer for folders is returned, because its error
    message names what the folder lacks.

    Parameters
    ----------
    path
        Path of the data.
    rate
        Rate that the user gave, Hz.
    given
        Names of the options for tables that the user gave, such as ``events``.

    Raises
    ------
    InputError
        No importer accepts the path with these options.
    """
    if not path.exists():
        raise InputError(f"{path} does not exist: check the path")
    importer = _accepting(path, given)
    every = list(IMPORTERS.values()) if importer is None else []
    for name in given if importer is None else []:
        able = [i for i in every if getattr(i, f"asks_{name}")]
        if not any(i.accepts(path, [name]) for i in able):
            titles = " or ".join(i.title for i in able)
            raise InputError(
                f"--{name} does not apply to {path}: give {titles}, or leave --{name} out"
            )
    if importer is None and len(given) > 1:
        options = " and ".join(f"--{name}" for name in given)
        raise InputError(f"{path} takes {options}, but not together: leave one of them out")
    if importer is None and path.is_dir():
        if not any(path.iterdir()):
            raise InputError(f"{path} is an empty folder: check the path")
        importer = next((i for i in every if i.marker is not None), None)
    if rate is not None and (importer is None or not importer.asks_rate):
        titles = " or ".join(i.title for i in IMPORTERS.values() if i.asks_rate)
        raise InputError(f"{path} states its rate: leave --rate out (it is for {titles})")
    if importer is None:
        hint = ": it is a recording already" if path.suffix == ".mcap" else ""
        *first, last = (i.title for i in IMPORTERS.values())
        raise InputError(f"{path} cannot be imported{hint}: give {', '.join(first)}, or {last}")
    return importer
