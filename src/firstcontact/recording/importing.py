"""Bring in what others have: finds the importer, writes recordings whole or not at all."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from firstcontact.core import Dataset, InputError
from firstcontact.core.files import resolved
from firstcontact.core.temporary import temporary_beside
from firstcontact.recording.arrays import import_hdf5, import_npz
from firstcontact.recording.csv import import_csv
from firstcontact.recording.dataset import write_dataset
from firstcontact.recording.header import Header
from firstcontact.recording.wav import import_wav

_BY_SUFFIX = {
    ".h5": import_hdf5,
    ".hdf5": import_hdf5,
    ".npz": import_npz,
}


def import_path(
    path: Path, out: Path, rate: float | None = None, source: str | None = None
) -> Dataset:
    """Import a folder of WAV files, or an HDF5, NPZ or CSV file, into a new folder.

    Parameters
    ----------
    path
        What to import.
    out
        Folder for the recordings; must be missing or empty.
    rate
        Hz, for a CSV file that does not say it.
    source
        One of :data:`firstcontact.recording.header.SOURCES`, for a file that does not
        say it.

    Returns
    -------
    Dataset
        What was written; its notes tell what was assumed.

    Raises
    ------
    InputError
        The input cannot be used or says another source, or ``out`` is in use; then
        nothing is written.
    """
    out = resolved(out)
    try:
        if out.exists() and (not out.is_dir() or any(out.iterdir())):
            raise InputError(f"{out} is there and not an empty folder: choose another --out")
    except OSError as error:
        raise _unwritable(out, error) from error
    dataset = _from(_read(path, rate), path, source)
    first = dataset.pinches[0]
    name = path.name.encode("utf-8", "replace").decode()
    notes = "\n".join((f"imported from {name}", *dataset.notes))
    header = Header(first.layout, dataset.source, str(first.data.dtype), notes=notes)
    try:
        with temporary_beside(out) as temporary:
            temporary.mkdir()
            write_dataset(dataset, temporary, header)
            temporary.replace(out)  # refused where it is not empty any more
    except OSError as error:
        raise _unwritable(out, error) from error
    except InputError as error:
        # The writer speaks of its own file and of what stays in it; here nothing stays.
        if isinstance(error.__cause__, OSError):
            raise _unwritable(out, error.__cause__) from error
        raise
    return dataset


def _from(dataset: Dataset, path: Path, source: str | None) -> Dataset:
    """The dataset with its source: what the file says, or else what the user does."""
    if source is not None and dataset.source not in ("unknown", source):
        raise InputError(
            f"{path} says that its source is {dataset.source} and --source {source}: leave "
            "--source out, or correct the file"
        )
    dataset = replace(dataset, source=source or dataset.source)
    if dataset.source != "unknown":
        return dataset
    note = "where the data come from is not known: import them with --source to say it"
    return replace(dataset, notes=(*dataset.notes, note))


def _unwritable(out: Path, error: OSError) -> InputError:
    return InputError(f"{out} cannot be written ({error.strerror}): check the folder and its disk")


def _read(path: Path, rate: float | None) -> Dataset:
    suffix = path.suffix.lower()
    if suffix == ".csv" and not path.is_dir():
        return import_csv(path, rate)
    if rate is not None:
        raise InputError(f"{path} says its own rate: leave --rate out (it is for CSV files)")
    if path.is_dir():
        return import_wav(path)
    if not path.exists():
        raise InputError(f"{path} does not exist: check the path")
    if suffix not in _BY_SUFFIX:
        hint = ": it is a recording already" if suffix == ".mcap" else ""
        raise InputError(
            f"{path} cannot be imported{hint}: give a folder of WAV files with labels.csv, or a "
            ".h5, .hdf5, .npz or .csv file"
        )
    return _BY_SUFFIX[suffix](path)
