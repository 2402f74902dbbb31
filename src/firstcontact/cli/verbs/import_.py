"""Command ``firstcontact import``: recordings from files of other formats."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from firstcontact.cli.options import Option
from firstcontact.core.text import counted
from firstcontact.recording import IMPORTERS

#: Option group for facts that files may lack.
UNSTORED = Option(group="what the files do not store")


@dataclass(frozen=True)
class Import:
    """Convert files of other formats into recordings."""

    path: Annotated[
        Path,
        Option(
            positional=True,
            help=f"A folder or file that one of these reads: {', '.join(IMPORTERS.names)}.",
        ),
    ]
    out: Path
    """New folder for the recordings; each session becomes one file."""
    rate: Annotated[float | None, UNSTORED] = None
    """Sampling rate, Hz."""

    source: Annotated[Literal["real", "twin", "synthetic", "unknown"] | None, UNSTORED] = None
    """Origin of the data, to be noted in the recordings; unknown by default."""

    sensor: Annotated[
        Literal["piezo", "accelerometer", "microphone", "hydrophone"] | None, UNSTORED
    ] = None
    """Kind of sensor; a microphone for WAV files by default."""

    events: Annotated[Path | None, UNSTORED] = None
    """Contacts in long files: a CSV file or an Audacity label track."""

    channels: Annotated[Path | None, UNSTORED] = None
    """CSV file that describes the signals of MATLAB or XDF files."""

    labels: Annotated[Path | None, UNSTORED] = None
    """CSV file with a row of labels per file; labels.csv by default."""

    find: Annotated[bool, UNSTORED] = False
    """Cut sound files into one pinch for each contact found in them."""

    def run(self) -> None:
        from firstcontact import import_recordings

        dataset = import_recordings(
            self.path,
            self.out,
            rate=self.rate,
            source=self.source,
            sensor=self.sensor,
            events=self.events,
            channels=self.channels,
            labels=self.labels,
            find=self.find,
        )
        layout = dataset.layout
        sessions = len(set(dataset.sessions.tolist()))
        print(
            f"{counted(len(dataset), 'pinch')} of "
            f"{counted(len(set(dataset.specimens.tolist())), 'specimen')} in "
            f"{counted(sessions, 'session')}, {counted(layout.width, 'channel')} at "
            f"{layout.rate:g} Hz, "
            f"{sum(p.first is not None for p in dataset.pinches)} with a known first contact, "
            f"source {dataset.source}"
        )
        for note in dataset.notes:
            print(note if note.startswith("warning: ") else f"note: {note}")
        print(f"written to {self.out}")
