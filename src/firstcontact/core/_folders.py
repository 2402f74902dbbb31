"""Folders that are replaced whole, or not at all.

A folder that holds something cannot be replaced in one step. So the new one is made whole
under a temporary name, flushed to the disk, and then two renames follow each other: the
old one to ``.NAME.XXXXXXXX.old`` and the new one to its name. Whoever is killed, or out of
space, before them has changed nothing. Between them, for some microseconds, nothing is
under the name: a reader finds no folder and is told where the old one is, and the next
writer puts it back before it begins. After them only the old one is still to be removed.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from firstcontact.core._atomic import temporaries, temporary_path
from firstcontact.core._errors import InputError
from firstcontact.core._files import resolve_path

_OLD = re.compile(r"\.(?P<of>.+)\.[0-9a-f]{8}\.old", re.DOTALL)


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """A new, empty folder that becomes ``path`` on success, in place of what is there.

    On an exception it is removed and ``path`` is as it was.

    Raises
    ------
    InputError
        ``path`` cannot be replaced: it is a file, a mounted disk or the folder
        that one is in, or another process is replacing it.
    OSError
        It cannot be written; names ``path``.
    """
    path = resolve_path(path)
    _check(path)
    try:
        with temporary_path(path) as new:
            _check_alone(path, new.parent)
            _recover(path)
            new.mkdir()
            yield new
            _flush(new)
            _swap(path, new)
    except OSError as error:
        if error.filename is not None:
            raise
        # A full disk says so without a name.
        raise OSError(error.errno, error.strerror, str(path)) from error


def displaced_folder(path: Path) -> Path | None:
    """What was at ``path`` when somebody was killed between two renames; None if nothing was."""
    path = resolve_path(path)
    if path.exists():
        return None
    found = _old(path)
    return found[-1] if found else None


def _check(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file: name a folder")
    if path.is_mount():
        raise InputError(
            f"{path} is a disk of its own and cannot be replaced whole: name a folder in it"
        )
    with suppress(FileNotFoundError):  # the folder that one is in may have been removed
        if path.exists() and Path.cwd().is_relative_to(path):
            raise InputError(
                f"{path} is the folder that you are in and cannot be replaced whole: "
                "name another, or go elsewhere"
            )


def _check_alone(path: Path, own: Path) -> None:
    """Refuse to work beside another writer; those that were killed have been swept."""
    if any(other.name != own.name for other in temporaries(path.parent, path.name)):
        raise InputError(
            f"{path}: another process is writing it: wait until it has ended, "
            "or name another folder"
        )


def _old(path: Path) -> list[Path]:
    """What stepped aside for a new folder and was not removed, the newest last."""
    if not path.parent.is_dir():
        return []
    there = [
        entry
        for entry in path.parent.iterdir()
        if (match := _OLD.fullmatch(entry.name)) and match["of"] == path.name
    ]
    return sorted(there, key=lambda old: old.lstat().st_ctime_ns)


def _recover(path: Path) -> None:
    """Put back what was killed between two renames; remove what was killed after them."""
    found = _old(path)
    if found and not path.exists():
        found.pop().rename(path)
    for old in found:
        shutil.rmtree(old, ignore_errors=True)


def _swap(path: Path, new: Path) -> None:
    if path.exists():
        shutil.copymode(path, new)
    try:
        new.rename(path)  # nothing is there, or an empty folder
        return
    except OSError as error:
        if error.errno not in (errno.ENOTEMPTY, errno.EEXIST):
            raise
    old = path.with_name(f".{path.name}.{uuid4().hex[:8]}.old")
    try:
        path.rename(old)
        new.rename(path)
    except BaseException:
        if old.exists() and not path.exists():
            old.rename(path)
        raise
    _flush_one(path.parent)
    shutil.rmtree(old, ignore_errors=True)


def _flush(folder: Path) -> None:
    """To the disk itself: a rename may otherwise get there before what it names."""
    for place, _, names in os.walk(folder):
        for name in names:
            _flush_one(Path(place, name))
        _flush_one(Path(place))


def _flush_one(path: Path) -> None:
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(number)
    finally:
        os.close(number)
