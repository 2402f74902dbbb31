"""Atomic reads and writes of files."""

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

#: Path of a file or folder that a Python caller may pass.
AnyPath = str | os.PathLike[str]

#: Error numbers of disks without hard links.
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.EMLINK, errno.ENOSYS)
#: Largest number of files and folders that a search visits.
MOST_ENTRIES = 100_000


def given_path(path: object, parameter: str = "path") -> Path:
    """Return a path that a caller gave, which no library was asked for yet.

    Raises
    ------
    InputError
        The value is no path, or holds a zero byte.
    """
    if not isinstance(path, str | os.PathLike):
        raise InputError(f"{path!r} is no path: give the path as text", parameter=parameter)
    if "\0" in os.fspath(path):
        raise InputError(
            f"{os.fspath(path)!r} holds a zero byte, which no path may: remove it",
            parameter=parameter,
        )
    return Path(path)


def resolve_path(path: Path) -> Path:
    """Return the absolute path without links. The path need not exist.

    Raises
    ------
    InputError
        The path is a link that leads back to itself.
    """
    try:
        return path.resolve()
    except (RuntimeError, OSError) as error:  # Python 3.11 and 3.12 raise RuntimeError
        raise InputError(f"{path} is a link that leads to itself: choose another path") from error


def files_below(folder: Path, suffix: str, most: int = MOST_ENTRIES) -> list[Path]:
    """Return the files with this suffix (lower case) in a folder and below it, sorted by name.

    The search does not follow links to folders. It skips temporary files of writers.

    Raises
    ------
    InputError
        There are more than ``most`` files and folders: the user may have named a whole disk.
    """
    matches: list[Path] = []
    entries = 0
    for parent, folders, names in os.walk(folder):
        entries += len(folders) + len(names)
        if entries > most:
            raise InputError(
                f"{folder} holds more than {most:,} files and folders: name the folder with your "
                "data"
            )
        matches += [Path(parent, name) for name in names if name.lower().endswith(suffix)]
    return sorted(path for path in matches if not is_temporary(path, folder))


def open_regular(path: Path) -> IO[bytes]:
    """Open a regular file for reading, and never wait for a pipe or a device.

    Raises
    ------
    InputError
        The path names a folder, a pipe, a socket or a device.
    OSError
        The file does not exist or may not be read.
    """
    # Without O_NONBLOCK, opening a named pipe waits for a writer.
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    if not S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise InputError(f"{path} is not a regular file: give a file")
    return os.fdopen(number, "rb")


def read_regular(path: Path, most: int) -> bytes:
    """Return the contents of a regular file of at most ``most`` bytes.

    Raises
    ------
    InputError
        The path names no regular file, see :func:`open_regular`, or the file is longer.
    OSError
        The file does not exist or cannot be read.
    """
    with open_regular(path) as stream:
        # read(n) allocates n bytes, so n is the file's size, unless the file grows.
        size = min(os.fstat(stream.fileno()).st_size, most) + 1
        data = stream.read(size)
        if len(data) == size <= most:
            data += stream.read(most + 1 - size)
    if len(data) > most:
        raise InputError(f"{path} has more than {most} bytes: choose the right file")
    return data


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path with the same file name. The file written there replaces ``path``.

    This happens at the end of the ``with`` block. On an exception the temporary file is removed,
    and ``path`` stays unchanged.
    """
    with temporary_path(path) as temporary:
        yield temporary
        temporary.replace(path)


@contextmanager
def creating(path: Path) -> Iterator[Path]:
    """Yield a temporary path like :func:`replacing`, for a file that must not exist yet.

    Raises
    ------
    FileExistsError
        The file exists, or another process created it meanwhile. That file stays unchanged.
    OSError
        The file cannot be written.
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
    """Raise the OSError that :func:`replacing` would raise for ``path``, if any. Change nothing."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    with temporary_path(path) as temporary:
        temporary.touch()


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file atomically."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, tree: Any) -> None:
    """Write a JSON file atomically. NaN is an error because JSON has none."""
    write_text(path, json.dumps(tree, indent=2, allow_nan=False) + "\n")
