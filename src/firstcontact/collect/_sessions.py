"""Files of a session: one at first, and one more after each interruption."""

from __future__ import annotations

import os
import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from firstcontact.core import InputError, Label
from firstcontact.device import Descriptor
from firstcontact.recording import cut, read_recording


@dataclass(frozen=True, slots=True)
class SoFar:
    """Files and pinches of a session that are already in a folder."""

    path: Path
    counts: Counter[Label] = field(default_factory=Counter)
    files: tuple[Path, ...] = ()
    unreadable: tuple[str, ...] = ()


def so_far(folder: Path, session: str, descriptor: Descriptor) -> SoFar:
    """Return the files and pinches of a session that a folder holds.

    The first file of session 3 is ``session-3.mcap``. After an interruption the next file is
    ``session-3.part2.mcap``, because recordings are never overwritten. A file that cannot be read
    stays as it is: its recorder was killed before it wrote a sample.

    Raises
    ------
    InputError
        A file with the session's name belongs to another session, or has other columns and cannot
        join the same dataset.
    """
    stem = "session-" + (re.sub(r"[^\w.+-]+", "-", session) or "-")
    pinches_by_label: Counter[Label] = Counter()
    files: list[Path] = []
    unreadable: list[str] = []
    path = folder / f"{stem}.mcap"
    while os.path.lexists(path):
        parts = len(files) + len(unreadable) + 1
        part, path = path, folder / f"{stem}.part{parts + 1}.mcap"
        try:
            recording = read_recording(part)
        except InputError as error:
            unreadable.append(str(error))
            continue
        header = recording.header
        if header.session != session:
            raise InputError(
                f"{part} belongs to session {header.session!r}, not to {session!r}: choose "
                "another name or folder",
                parameter="session",
            )
        if (header.layout, header.source) != (descriptor.layout, descriptor.source):
            raise InputError(
                f"{part} was recorded with another sensor or layout than this device has: choose "
                "another folder",
                parameter="out",
            )
        pinches_by_label.update(
            mark.label for mark in recording.pinches if cut(recording, mark) is not None
        )
        files.append(part)
    return SoFar(path, pinches_by_label, tuple(files), tuple(unreadable))
