"""Temporary files and folders for atomic writes.

A writer creates the folder ``.NAME.XXXXXXXX.part`` beside the target and locks it while the process
lives. A folder without a lock is the leftover of a killed writer. This also works on a disk that
several machines share. The next writer removes the leftovers.
"""

from __future__ import annotations

import errno
import fcntl
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

_NAME = re.compile(r"\.(?P<of>.+)\.[0-9a-f]{8}\.part", re.DOTALL)


def is_temporary(path: Path, below: Path) -> bool:
    """Return True if a path lies in a temporary folder of any writer, running or killed."""
    return any(_NAME.fullmatch(part) for part in path.relative_to(below).parts)


@contextmanager
def temporary_path(path: Path) -> Iterator[Path]:
    """Yield a path in a temporary folder next to ``path``, with the same file name.

    The folder is on the same disk, so a rename can move the file to ``path``.

    Missing parent folders are created. The temporary folder and its contents are removed when the
    ``with`` block ends. Leftovers of killed writers for the same path are removed first.

    Raises
    ------
    OSError
        The folder cannot be created.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    sweep(path.parent, path.name)
    folder, lock = _make(path)
    try:
        yield folder / path.name
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def sweep(folder: Path, name: str | None = None) -> None:
    """Remove the leftovers of killed writers in a folder, for one target ``name`` or for all."""
    with suppress(OSError):  # the folder does not exist
        for path in temporaries(folder, name):
            if not path.is_symlink():
                _remove_if_dead(path)


def temporaries(folder: Path, name: str | None = None) -> list[Path]:
    """Return the temporary folders of running and killed writers in a folder."""
    matches = ((entry, _NAME.fullmatch(entry.name)) for entry in folder.iterdir())
    return [entry for entry, match in matches if match and name in (None, match["of"])]


def _make(path: Path) -> tuple[Path, int]:
    """Create a temporary folder and lock it. Return the folder and the descriptor of the lock."""
    while True:
        folder = path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")
        folder.mkdir()
        try:
            lock = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
        except FileNotFoundError:
            continue
        with suppress(OSError):  # the disk has no locks: no other writer can sweep there either
            fcntl.flock(lock, fcntl.LOCK_EX)
        # Another writer may have swept the folder before this one locked it.
        if _is_locked_folder(folder, lock):
            return folder, lock
        os.close(lock)


def _remove_if_dead(path: Path) -> None:
    try:
        lock = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK | os.O_NOFOLLOW)
    except OSError:
        return
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
        else:  # older versions created files
            path.unlink()
    except OSError:
        pass  # a running writer has locked it, or this process may not remove it
    finally:
        os.close(lock)


def _is_locked_folder(folder: Path, lock: int) -> bool:
    try:
        current = folder.stat()
    except OSError as error:
        if error.errno != errno.ENOENT:
            raise
        return False
    mine = os.fstat(lock)
    return (current.st_dev, current.st_ino) == (mine.st_dev, mine.st_ino)
