"""Atomic replacement of folders.

No system call replaces a folder that holds files. So the new folder is written under a temporary
name and flushed to the disk. Two renames follow: the old folder becomes ``.NAME.XXXXXXXX.old``,
then the new one takes its name.

- A failure before the renames changes nothing.
- Between the renames, for some microseconds, the name does not exist. A reader that needs the
  folder then reports where the old one is. The next writer restores the old folder first.
- After the renames, only the old folder remains to be removed.
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
    """Yield a new, empty folder that replaces ``path`` on success.

    On an exception the new folder is removed and ``path`` stays unchanged.

    Raises
    ------
    InputError
        ``path`` cannot be replaced: it is a file, a mounted disk or the working folder, or
        another process is replacing it.
    OSError
        The folder cannot be written. The error names ``path``.
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
        # The error of a full disk holds no file name.
        raise OSError(error.errno, error.strerror, str(path)) from error


def displaced_folder(path: Path) -> Path | None:
    """Return the old folder if a writer was killed between the two renames, else None."""
    path = resolve_path(path)
    if path.exists():
        return None
    displaced = _displaced(path)
    return displaced[-1] if displaced else None


def _check(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise InputError(f"{path} is a file: choose a folder")
    if path.is_mount():
        raise InputError(f"{path} is a mounted disk and cannot be replaced: choose a folder in it")
    with suppress(FileNotFoundError):  # the working folder may have been removed
        if path.exists() and Path.cwd().is_relative_to(path):
            raise InputError(
                f"{path} is the working folder and cannot be replaced: "
                "choose another folder, or run the command from elsewhere"
            )


def _check_alone(path: Path, temporary: Path) -> None:
    """Raise an error if another writer is active. Call it after leftovers were removed."""
    if any(other.name != temporary.name for other in temporaries(path.parent, path.name)):
        raise InputError(
            f"{path}: another process is writing this folder: wait for it to end, "
            "or choose another folder"
        )


def _displaced(path: Path) -> list[Path]:
    """Return the old folders that were moved aside but not removed, newest last."""
    if not path.parent.is_dir():
        return []
    matches = [
        entry
        for entry in path.parent.iterdir()
        if (match := _OLD.fullmatch(entry.name)) and match["of"] == path.name
    ]
    return sorted(matches, key=lambda old: old.lstat().st_ctime_ns)


def _recover(path: Path) -> None:
    """Restore the old folder if a writer was killed between the renames. Remove older copies."""
    displaced = _displaced(path)
    if displaced and not path.exists():
        displaced.pop().rename(path)
    for old in displaced:
        shutil.rmtree(old, ignore_errors=True)


def _swap(path: Path, new: Path) -> None:
    if path.exists():
        shutil.copymode(path, new)
    try:
        new.rename(path)  # the target does not exist, or is an empty folder
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
    """Flush a folder to the disk. Otherwise its renaming may reach the disk before its contents."""
    for parent, _, names in os.walk(folder):
        for name in names:
            _flush_one(Path(parent, name))
        _flush_one(Path(parent))


def _flush_one(path: Path) -> None:
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(number)
    finally:
        os.close(number)
