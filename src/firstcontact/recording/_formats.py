"""What can be imported and exported, by name. A new format is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core import Registry

if TYPE_CHECKING:
    from firstcontact.core import Dataset


@dataclass(frozen=True, slots=True)
class Importer:
    """How files of one kind come in.

    Parameters
    ----------
    name
        Under which it is registered.
    title
        What it takes, as messages say it: "a .csv file".
    read
        From a path and the rate in Hz that a person gave or None, to a dataset; what it asks
        for besides comes by keyword (``sensor``, ``events``, ``channels``, ``labels``), None
        where nobody gave it. Raises InputError naming the file, what is wrong in it and the
        remedy.
    suffixes
        Of its files, in lower case; none where it takes a folder.
    marker
        Name of the file that a folder must hold to be taken, where it takes folders.
    asks_rate
        Whether its files need not say their own rate.
    asks_sensor
        Whether they do not say what they were recorded with.
    asks_events
        Whether a table can say where their contacts are. Any folder is then taken with one.
    asks_channels
        Whether a table can say what their signals are. Any folder is then taken with one.
    asks_labels
        Whether the labels of a folder's files can be elsewhere than in it.
    extra, modules
        Of this package that it needs, and the modules that come with it.
    """

    name: str
    title: str
    read: Callable[..., Dataset]
    suffixes: tuple[str, ...] = ()
    marker: str | None = None
    asks_rate: bool = False
    asks_sensor: bool = False
    asks_events: bool = False
    asks_channels: bool = False
    asks_labels: bool = False
    extra: str = ""
    modules: tuple[str, ...] = ()

    def accepts(self, path: Path, given: Collection[str] = ()) -> bool:
        """Whether this is for it, with these options given, by their names."""
        tables = {"events", "channels", "labels"} & set(given)
        if not all(getattr(self, f"asks_{name}") for name in tables):
            return False
        if path.is_dir():
            marked = self.marker is not None and (path / self.marker).exists()
            return marked or bool(tables)
        return path.suffix.lower() in self.suffixes


@dataclass(frozen=True, slots=True)
class Exporter:
    """How a dataset goes out.

    Parameters
    ----------
    name
        Under which it is registered.
    write
        Writes a dataset of one pinch or more to a path that is free. Raises InputError if the
        format cannot hold it.
    extra, modules
        Of this package that it needs, and the modules that come with it.
    groups
        Whether it holds slower groups, too.
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
        "wav": f"{_HERE}._wav:WAV",
        "events": f"{_HERE}._events:EVENTS",
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
        "csv": f"{_HERE}._export_csv:CSV",
        "parquet": f"{_HERE}._export_parquet:PARQUET",
        "hdf5": f"{_HERE}._export_hdf5:HDF5",
        "mcap-plot": f"{_HERE}._export_mcap_plot:MCAP_PLOT",
    },
    base=f"{_HERE}._formats:Exporter",
    instances=True,
)
