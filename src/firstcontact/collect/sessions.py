"""One file a session, and one more after each interruption."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from firstcontact.core import InputError, Label
from firstcontact.device import Descriptor
from firstcontact.recording import read_recording
from firstcontact.recording.dataset import cut


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
    """

    path: Path
    done: Counter[Label] = field(default_factory=Counter)
    files: tuple[Path, ...] = ()


def so_far(folder: Path, session: str, descriptor: Descriptor) -> SoFar:
    """Look up how far a session has come.

    The first file of session 3 is ``session-3.mcap``; what is recorded after an
    interruption goes to ``session-3.part2.mcap`` and so on, since recordings are
    never overwritten.

    Raises
    ------
    InputError
        A file of the session cannot be read, belongs to another session, or
        was recorded with other columns, so that the two cannot be one dataset.
    """
    stem = "session-" + (re.sub(r"[^\w.+-]+", "-", session) or "-")
    done: Counter[Label] = Counter()
    files = []
    path = folder / f"{stem}.mcap"
    while path.exists():
        recording = read_recording(path)
        header = recording.header
        if header.session != session:
            raise InputError(
                f"{path} belongs to session {header.session!r} and not to {session!r}: choose "
                "another --session or --out"
            )
        if (header.layout, header.source) != (descriptor.layout, descriptor.source):
            raise InputError(
                f"{path} was recorded with another sensor or layout than this device has: choose "
                "another --out"
            )
        done.update(mark.label for mark in recording.pinches if cut(recording, mark) is not None)
        files.append(path)
        path = folder / f"{stem}.part{len(files) + 1}.mcap"
    return SoFar(path, done, tuple(files))
