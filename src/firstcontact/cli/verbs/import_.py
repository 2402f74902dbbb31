"""``firstcontact import``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from firstcontact.core import counted
from firstcontact.recording import IMPORTERS


@dataclass(frozen=True)
class Import:
    """Convert files of other formats into recordings."""

    path: Annotated[
        tyro.conf.Positional[Path],
        tyro.conf.arg(
            help=f"A folder or file that one of these reads: {', '.join(IMPORTERS.names)}."
        ),
    ]
    """What to import."""
    out: Path
    """New folder for the recordings, one file a session."""
    rate: float | None = None
    """Sampling rate, Hz, for files that do not store it."""

    source: Literal["real", "twin", "synthetic", "unknown"] | None = None
    """Source of the data, for files that do not store it; unknown by default."""

    sensor: Literal["piezo", "accelerometer", "microphone", "hydrophone"] | None = None
    """Kind of sensor, for files that do not store it; a microphone for WAV files."""

    events: Path | None = None
    """Contacts in long files: CSV file with onset_s or onset_sample and labels, or an Audacity
    label track (.txt)."""

    channels: Path | None = None
    """CSV file that describes the signals of MATLAB or XDF files, one row each."""

    labels: Path | None = None
    """CSV file with one row of labels per file of a folder; its labels.csv by default."""

    def run(self) -> None:
        """Import, and print what was read and assumed."""
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
            print(f"note: {note}")
        print(f"written to {self.out}")
