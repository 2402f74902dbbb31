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
    """Turn what others have into recordings."""

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
    """Samples a second, Hz, for a file that need not say it and does not."""

    source: Literal["real", "twin", "synthetic", "unknown"] | None = None
    """Where the data come from, where the file does not say it; then they are unknown."""

    sensor: Literal["piezo", "accelerometer", "microphone", "hydrophone"] | None = None
    """What was recorded with, where the files do not say it: of WAV files a microphone."""

    events: Path | None = None
    """Where the contacts are in a long WAV, FLAC or XDF file, or in each sound file of a folder: a
    CSV with a row each, with its time in onset_s or its sample in onset_sample, and any labels;
    or of one file an Audacity label track (.txt)."""

    channels: Path | None = None
    """CSV that says what the signals of MATLAB or XDF files are, a row each: its variable or
    stream, sensor, finger, rate_hz, column, unit, scale and offset."""

    labels: Path | None = None
    """CSV with a row of labels for each file of a folder, where it is not labels.csv in it."""

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
