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
from uuid import uuid4

from firstcontact.core.errors import InputError


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
        data = stream.read(most + 1)
    if len(data) > most:
        raise InputError(f"{path} has more than {most} bytes: give the right file")
    return data


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary name beside ``path`` that becomes ``path`` on success.

    On an exception the temporary file is removed and ``path`` is as it was.
    """
    temporary = _beside(path)
    try:
        yield temporary
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def try_replacing(path: Path) -> None:
    """Raise the OSError that :func:`replacing` would; ``path`` stays as it is."""
    if path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    temporary = _beside(path)
    try:
        temporary.touch(exist_ok=False)
    finally:
        temporary.unlink(missing_ok=True)


def _beside(path: Path) -> Path:
    """A name of its own in the folder of ``path``, which is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file whole."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, tree: Any) -> None:
    """Write a JSON file whole; NaN is an error, since JSON has none."""
    write_text(path, json.dumps(tree, indent=2, allow_nan=False) + "\n")
