"""Registries of import and export formats. To add one, write one file and add one line here."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import Registry
from firstcontact.core.files import file_in

if TYPE_CHECKING:
    from firstcontact.core import Dataset


@dataclass(frozen=True, slots=True)
class Importer:
    """Importer that reads datasets from one file format.

    Parameters
    ----------
    name
        Name in the registry ``IMPORTERS``.
    title
        Description of the accepted files, for messages: "a .csv file".
    read
        Function that makes a dataset from a path and a sampling rate in Hz (or None). It gets the
        other ``options`` by keyword, None if not given. It raises InputError with the file, the
        problem and the remedy.
    suffixes
        File name extensions that the importer accepts, such as ".csv"; empty for folders.
    marker
        Name of a file that an accepted folder must contain.
    options
        Parameters of :func:`firstcontact.import_recordings` that some files need: "rate", "sensor",
        or the tables "events", "channels" and "labels". An importer with tables accepts any folder
        if the user gives one of these tables.
    extra, modules
        Name of this package's pip extra that ``read`` needs, and the modules that it installs.
    """

    name: str
    title: str
    read: Callable[..., Dataset]
    suffixes: tuple[str, ...] = ()
    marker: str | None = None
    options: tuple[str, ...] = ()
    extra: str = ""
    modules: tuple[str, ...] = ()

    def accepts(self, path: Path, tables: Collection[str] = ()) -> bool:
        """Return True if the importer accepts a path, and the ``tables`` that the user gave.

        ``tables`` are the names of options, such as "events".
        """
        if not set(tables) <= set(self.options):
            return False
        if path.is_dir():
            return bool(tables) or (self.marker is not None and file_in(path, self.marker).exists())
        return path.suffix.lower() in self.suffixes


@dataclass(frozen=True, slots=True)
class Exporter:
    """Exporter that writes datasets in one file format.

    Parameters
    ----------
    name
        Name in the registry ``EXPORTERS``.
    write
        Function that writes a dataset of at least one pinch to a new path. It raises InputError if
        the format cannot store the dataset.
    extra, modules
        Name of this package's pip extra that ``write`` needs, and the modules that it installs.
    groups
        True if the format also stores channels with a lower rate (groups of the layout).
    """

    name: str
    write: Callable[[Dataset, Path], None]
    extra: str = ""
    modules: tuple[str, ...] = ()
    groups: bool = False


_HERE = "firstcontact.recording"

IMPORTERS: Registry[Importer] = Registry(
    "importer",
    "firstcontact.importers",
    {
        "wav": f"{_HERE}.sound:WAV",
        "events": f"{_HERE}.sound:EVENTS",
        "hdf5": f"{_HERE}._arrays:HDF5",
        "npz": f"{_HERE}._arrays:NPZ",
        "csv": f"{_HERE}._csv:CSV",
        "mat": f"{_HERE}._mat:MAT",
        "xdf": f"{_HERE}._xdf:XDF",
    },
    base=f"{_HERE}._formats:Importer",
    instances=True,
)

EXPORTERS: Registry[Exporter] = Registry(
    "format",
    "firstcontact.exporters",
    {
        "csv": f"{_HERE}._exporting:CSV",
        "parquet": f"{_HERE}._exporting:PARQUET",
        "hdf5": f"{_HERE}._exporting:HDF5",
        "mcap-plot": f"{_HERE}._export_mcap_plot:MCAP_PLOT",
    },
    base=f"{_HERE}._formats:Exporter",
    instances=True,
)
