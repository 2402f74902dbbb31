"""What can be imported and exported, by name. A new format is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from firstcontact.core.registry import Registry

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
        From a path, the rate in Hz that a person gave or None, and where it asks for it the
        sensor or None, to a dataset. Raises InputError naming the file, what is wrong in it
        and the remedy.
    suffixes
        Of its files, in lower case; none where it takes a folder.
    marker
        Name of the file that a folder must hold to be taken, where it takes folders.
    asks_rate
        Whether its files need not say their own rate.
    asks_sensor
        Whether they do not say what they were recorded with.
    asks_events
        Whether a table says where their contacts are; ``read`` takes it after the sensor. Any
        folder is then taken.
    """

    name: str
    title: str
    read: Callable[..., Dataset]
    suffixes: tuple[str, ...] = ()
    marker: str | None = None
    asks_rate: bool = False
    asks_sensor: bool = False
    asks_events: bool = False

    def accepts(self, path: Path) -> bool:
        """Whether this is for it."""
        if path.is_dir():
            return self.asks_events or (self.marker is not None and (path / self.marker).exists())
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
    """

    name: str
    write: Callable[[Dataset, Path], None]
    extra: str = ""
    modules: tuple[str, ...] = ()


_HERE = "firstcontact.recording"

IMPORTERS: Registry[Importer] = Registry(
    "importer",
    "firstcontact.importers",
    {
        "wav": f"{_HERE}.wav:WAV",
        "events": f"{_HERE}.events:EVENTS",
        "hdf5": f"{_HERE}.arrays:HDF5",
        "npz": f"{_HERE}.arrays:NPZ",
        "csv": f"{_HERE}.csv:CSV",
    },
)

EXPORTERS: Registry[Exporter] = Registry(
    "format",
    "firstcontact.exporters",
    {
        "csv": f"{_HERE}.export_csv:CSV",
        "parquet": f"{_HERE}.export_parquet:PARQUET",
        "hdf5": f"{_HERE}.export_hdf5:HDF5",
    },
)
