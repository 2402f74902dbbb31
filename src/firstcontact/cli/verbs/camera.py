"""``firstcontact camera``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tyro


@dataclass(frozen=True)
class Camera:
    """Compare contact times of the strips with a high-speed camera."""

    path: tyro.conf.Positional[Path]
    """Recording with strips."""
    contacts: Path
    """CSV file of the camera's contacts, with the columns pinch,finger,time_s."""
    fps: float = 960.0
    """Frames per second of the camera."""

    def run(self) -> None:
        """Print agreement, offset and drift, and which contacts disagree."""
        from firstcontact.collect import compare, in_words, read_contacts
        from firstcontact.recording import read_recording

        contacts = read_contacts(self.contacts)
        for line in in_words(compare(read_recording(self.path), contacts, self.fps)):
            print(line)
