"""Command ``firstcontact camera``: contact times of the strips, compared with a camera's."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli.options import Option


@dataclass(frozen=True)
class Camera:
    """Compare contact times from the copper strips with those from a high-speed camera."""

    path: Annotated[Path, Option(positional=True)]
    """Recording with channels of copper strips on the fingers."""
    times: Path
    """CSV file of the camera's contacts, with the columns pinch,finger,time_s."""
    fps: float = 960.0
    """Frames per second of the camera."""

    def run(self) -> None:
        from firstcontact.collect.camera import compare, in_words, read_contacts
        from firstcontact.recording import read_recording

        contacts = read_contacts(self.times)
        for line in in_words(compare(read_recording(self.path), contacts, self.fps)):
            print(line)
