"""Files that are there whole, or not at all."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from stat import S_ISREG
from typing import IO, Any

from firstcontact.core._atomic import is_temporary, temporary_path
from firstcontact.core._errors import InputError

#: Path of a file or folder as callers from Python may give it.
AnyPath = str | os.PathLike[str]

#: What a disk says that has no hard links.
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.EMLINK, errno.ENOSYS)
#: Files and folders that are looked at for those that are wanted.
MOST_ENTRIES = 100_000


def resolve_path(path: Path) -> Path:
    """Where a path leads, whether something is there or not.

    Raises
    ------
    InputError
        It is a link that leads back to itself.
    """
    try:
        return path.resolve()
    except (RuntimeError, OSError) as error:  # Python 3.11 and 3.12 raise RuntimeError
        raise InputError(f"{path} leads nowhere, its links go in a circle: name another") from error


def files_below(folder: Path, suffix: str, most: int = MOST_ENTRIES) -> list[Path]:
    """Files with this suffix (in small letters) in a folder and below it, by their names.

    Links to folders are not followed; what is being made, or was left half made, is not there.

    Raises
    ------
    InputError
        More than ``most`` files and folders are there: a whole disk was named, perhaps.
    """
    found: list[Path] = []
    entries = 0
    for above, folders, names in os.walk(folder):
        entries += len(folders) + len(names)
        if entries > most:
            raise InputError(
                f"{folder} has more than {most:,} files and folders in it: name the one that is "
                "meant"
            )
        found += [Path(above, name) for name in names if name.lower().endswith(suffix)]
    return sorted(path for path in found if not is_temporary(path, folder))


def open_regular(path: Path) -> IO[bytes]:
    """Open a file for reading that is one: never waits for a pipe or a device.

    Raises
    ------
    InputError
        The path names a folder, a pipe, a socket or a device.
    OSError
        It is not there or may not be read.
    """
    # Without O_NONBLOCK, opening a named pipe waits for somebody who writes to it.
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    if not S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise InputError(f"{path} is not a regular file: give a file")
    return os.fdopen(number, "rb")


def read_regular(path: Path, most: int) -> bytes:
    """All of a regular file that has at most so many bytes.

    Raises
    ------
    InputError
        As :func:`open_regular`, or it is longer.
    OSError
        It is not there or cannot be read.
    """
    with open_regular(path) as stream:
        # What is asked for is allocated: no more than the file has, unless it grows.
        size = min(os.fstat(stream.fileno()).st_size, most) + 1
        data = stream.read(size)
        if len(data) == size <= most:
            data += stream.read(most + 1 - size)
    if len(data) > most:
        raise InputError(f"{path} has more than {most} bytes: give the right file")
    return data


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary path, of the same name, that becomes ``path`` on success.

    On an exception it is removed and ``path`` is as it was.
    """
    with temporary_path(path) as temporary:
        yield temporary
        temporary.replace(path)


@contextmanager
def creating(path: Path) -> Iterator[Path]:
    """As :func:`replacing`, for a file that must not be there: neither before nor at the end.

    Raises
    ------
    FileExistsError
        It is there, or somebody made it meanwhile; that one stays as it is.
    OSError
        It cannot be written.
    """
    if os.path.lexists(path):
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    with temporary_path(path) as temporary:
        yield temporary
        try:
            os.link(temporary, path)  # unlike a rename, this never replaces
        except OSError as error:
            if error.errno not in _NO_LINKS:
                raise
            # A disk without links (FAT): take the name first, then fill it.
            os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL))
            temporary.replace(path)


def try_replacing(path: Path) -> None:
    """Raise the OSError that :func:`replacing` would; ``path`` stays as it is."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    with temporary_path(path) as temporary:
        temporary.touch()


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file whole."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, tree: Any) -> None:
    """Write a JSON file whole; NaN is an error, since JSON has none."""
    write_text(path, json.dumps(tree, indent=2, allow_nan=False) + "\n")
