"""Where something is made before it gets its name.

A folder ``.NAME.XXXXXXXX.part`` beside the place, locked by its writer for as long as the
process lives. So a killed writer's leftovers can be told from the work of one that runs,
on this machine or on a disk that others share, and are swept by the next one.
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
    """Whether a path lies in something that is being made, or was left, below a folder."""
    return any(_NAME.fullmatch(part) for part in path.relative_to(below).parts)


@contextmanager
def temporary_path(path: Path) -> Iterator[Path]:
    """A path of the same name in a folder of its own beside ``path``, on the same disk.

    The folder, and those that it is in, are made; it is removed at the end, with
    whatever still is in it. What killed writers left for the same path goes as well.

    Raises
    ------
    OSError
        It cannot be made.
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
    """Remove what killed writers left in a folder, for one name or for all.

    What a writer still holds stays, and so does what cannot be locked or removed.
    """
    with suppress(OSError):  # a folder that is not there
        for path in temporaries(folder, name):
            if not path.is_symlink():
                _remove_if_dead(path)


def temporaries(folder: Path, name: str | None = None) -> list[Path]:
    """What is being made in a folder, or was left there, for one name or for all.

    Raises
    ------
    OSError
        The folder cannot be looked into.
    """
    matches = ((entry, _NAME.fullmatch(entry.name)) for entry in folder.iterdir())
    return [entry for entry, match in matches if match and name in (None, match["of"])]


def _make(path: Path) -> tuple[Path, int]:
    """A new folder and the lock that is held on it."""
    while True:
        folder = path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")
        folder.mkdir()
        try:
            lock = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
        except FileNotFoundError:
            continue
        with suppress(OSError):  # a disk without locks: nobody can sweep there either
            fcntl.flock(lock, fcntl.LOCK_EX)
        # Someone may have swept it before the lock was ours.
        if _is_at(folder, lock):
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
        else:  # as older versions made them
            path.unlink()
    except OSError:
        pass  # it lives, or it is not ours to remove
    finally:
        os.close(lock)


def _is_at(folder: Path, lock: int) -> bool:
    try:
        there = folder.stat()
    except OSError as error:
        if error.errno != errno.ENOENT:
            raise
        return False
    mine = os.fstat(lock)
    return (there.st_dev, there.st_ino) == (mine.st_dev, mine.st_ino)
