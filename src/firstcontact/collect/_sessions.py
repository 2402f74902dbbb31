"""One file a session, and one more after each interruption."""

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
    """What a folder already holds of a session.

    Parameters
    ----------
    path
        The file to record to next; it does not exist.
    done
        Whole pinches by label.
    files
        What was recorded before.
    unreadable
        What else bears the session's name and holds nothing that can be read, and why: one
        sentence each.
    """

    path: Path
    done: Counter[Label] = field(default_factory=Counter)
    files: tuple[Path, ...] = ()
    unreadable: tuple[str, ...] = ()


def so_far(folder: Path, session: str, descriptor: Descriptor) -> SoFar:
    """Look up how far a session has come.

    The first file of session 3 is ``session-3.mcap``; what is recorded after an
    interruption goes to ``session-3.part2.mcap`` and so on, since recordings are
    never overwritten. A part that cannot be read (its recorder was killed as it appeared)
    is passed over and stays as it is.

    Raises
    ------
    InputError
        A file of the session belongs to another session, or was recorded with
        other columns, so that the two cannot be one dataset.
    """
    stem = "session-" + (re.sub(r"[^\w.+-]+", "-", session) or "-")
    done: Counter[Label] = Counter()
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
                f"{part} belongs to session {header.session!r} and not to {session!r}: choose "
                "another name or folder",
                parameter="session",
            )
        if (header.layout, header.source) != (descriptor.layout, descriptor.source):
            raise InputError(
                f"{part} was recorded with another sensor or layout than this device has: choose "
                "another folder",
                parameter="out",
            )
        done.update(mark.label for mark in recording.pinches if cut(recording, mark) is not None)
        files.append(part)
    return SoFar(path, done, tuple(files), tuple(unreadable))
