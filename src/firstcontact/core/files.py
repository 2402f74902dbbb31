"""Atomic reads and writes of files and folders.

A writer creates the folder ``.NAME.XXXXXXXX.part`` beside its target, and locks it while the
process lives. A folder without a lock is the leftover of a killed writer: the next writer of the
same target removes it. This also works on a disk that several machines share.

No system call replaces a folder that holds files. The old folder first becomes
``.NAME.XXXXXXXX.old``, then the new one takes its name. If the process is killed between these two
renames, readers report where the old folder is, and the next writer restores it.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from stat import S_ISREG
from typing import IO, Any
from uuid import uuid4

from firstcontact.core._errors import ArgumentError, FileError, InputError

#: Path of a file or folder that a Python caller may pass.
AnyPath = str | os.PathLike[str]

#: Error numbers of disks without hard links.
_NO_LINKS = (errno.EPERM, errno.ENOTSUP, errno.EMLINK, errno.ENOSYS)
#: Error numbers of a rename to a folder that holds files.
_NOT_EMPTY = (errno.ENOTEMPTY, errno.EEXIST)


def given_path(path: object, parameter: str = "path") -> Path:
    """Convert a caller's path to Path. Raise ArgumentError for an invalid type or characters."""
    if not isinstance(path, str | os.PathLike):
        raise ArgumentError(f"{path!r} is not a path: give the path as text", parameter=parameter)
    if "\0" in os.fspath(path):
        raise ArgumentError(
            f"{os.fspath(path)!r} contains a zero byte: remove it", parameter=parameter
        )
    try:
        os.lstat(path)
    except UnicodeEncodeError:
        message = f"{path!r} has characters that no path can have: remove them"
        raise ArgumentError(message, parameter=parameter) from None
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            start = f"{str(path)[:60]}..."
            message = f"a path is too long for this disk ({start!r}): give a shorter one"
            raise ArgumentError(message, parameter=parameter) from None
    return Path(path)


def resolved(path: Path) -> Path:
    """Return the absolute path without links. A link to itself is returned unchanged."""
    return Path(os.path.realpath(path))


def files_below(folder: Path, suffix: str) -> list[Path]:
    """Return the files with this suffix (lower case) in a folder and below it, sorted by name.

    Hidden files and folders are skipped: macOS puts ``._NAME`` beside each file on a memory stick.
    """
    matches: list[Path] = []
    for parent, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        visible = (name for name in names if not name.startswith("."))
        matches += [Path(parent, name) for name in visible if name.lower().endswith(suffix)]
    return sorted(matches)


def file_in(folder: Path, name: str) -> Path:
    """Return the path of the file called ``name`` in a folder.

    If there is none, return a file whose name differs only in case, or else ``folder / name``.
    """
    if (folder / name).exists() or not folder.is_dir():
        return folder / name
    alike = (path for path in sorted(folder.iterdir()) if path.name.lower() == name.lower())
    return next(alike, folder / name)


def open_regular(path: Path) -> IO[bytes]:
    """Open a file for reading. Raise FileError, without waiting, for a pipe or a device."""
    # Without O_NONBLOCK, opening a named pipe waits for a writer.
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    if not S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise FileError(f"{path} is not a regular file: give a file")
    return os.fdopen(number, "rb")


def read_regular(path: Path, most: int) -> bytes:
    """Return the bytes of a regular file. Raise FileError if it has more than ``most`` bytes."""
    with open_regular(path) as stream:
        if os.fstat(stream.fileno()).st_size > most:
            raise FileError(f"{path} has more than {most} bytes: choose the right file")
        return stream.read()


@contextmanager
def temporary_path(path: Path) -> Iterator[Path]:
    """Yield a path with the file name of ``path``, in a new temporary folder next to it.

    The temporary folder is removed at the end. Folders that killed writers left are removed first.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    for leftover in _abandoned_folders(path, "part"):
        _remove_if_dead(leftover)
    folder, lock = _create_locked_folder(path)
    try:
        yield folder / path.name
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def cache_path(name: str) -> Path:
    """Return the path ``name`` in this package's part of ``XDG_CACHE_HOME`` or ``~/.cache``."""
    base = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")  # noqa: PTH111
    if base.startswith("~"):  # as in a container whose user has no entry
        raise FileError("no folder of this user is known: set HOME or XDG_CACHE_HOME")
    return Path(base) / "firstcontact" / name


def make_once(folder: Path, make: Callable[[Path], object]) -> None:
    """Create ``folder`` by calling ``make``, unless it exists.

    ``make`` gets a temporary path at which to create the folder, so that other processes see it
    only when it is complete. Raises FileError if the folder cannot be written.
    """
    try:
        if folder.is_dir():
            return
        with temporary_path(folder) as making:
            make(making)
            making.rename(folder)
    except OSError as error:
        if error.errno not in _NOT_EMPTY:  # another program has made the folder meanwhile
            raise FileError(
                f"{folder} cannot be written ({error.strerror or error}): make room on the disk, "
                "or name another cache folder in the variable XDG_CACHE_HOME"
            ) from error


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a temporary path with the same file name. The file written there replaces ``path``.

    If the body raises, ``path`` stays as it was.
    """
    with temporary_path(path) as temporary:
        yield temporary
        temporary.replace(path)


@contextmanager
def creating(path: Path) -> Iterator[Path]:
    """Yield a temporary path like :func:`replacing`. Raise FileExistsError if ``path`` exists."""
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
            path.touch(exist_ok=False)
            temporary.replace(path)


@contextmanager
def replacing_folder(path: Path) -> Iterator[Path]:
    """Yield a new, empty folder, which replaces the folder ``path`` unless the body raises."""
    path = resolved(path)
    _check_replaceable(path)
    try:
        with temporary_path(path) as new:
            if (displaced := displaced_folder(path)) is not None:
                displaced.rename(path)
            for leftover in _abandoned_folders(path, "old"):
                shutil.rmtree(leftover, ignore_errors=True)
            new.mkdir()
            yield new
            try:
                _swap(path, new)
            except OSError as error:
                raise written_elsewhere(
                    path, error, lambda folder: shutil.copytree(new, folder, dirs_exist_ok=True)
                ) from error
    except OSError as error:
        if error.filename is not None:
            raise
        # The error of a full disk holds no file name.
        raise OSError(error.errno, error.strerror, str(path)) from error


def written_elsewhere(
    path: Path, error: OSError, write: Callable[[Path], object]
) -> OSError | InputError:
    """Save a folder in another place because ``path`` cannot be written. Return the error to raise.

    ``write`` fills the folder that it gets. The returned error names both places. If no other place
    can be written either, the result is ``error``.
    """
    if path.parent.suffix == ".part":  # this folder is temporary
        path = path.parent.with_name(path.name)
    for base in (path.parent, Path(tempfile.gettempdir())):
        place = None
        try:
            place = Path(tempfile.mkdtemp(prefix=f"{path.name}-", dir=base))
            write(place)
        except OSError:
            if place is not None:  # a part of the files would look like all of them
                shutil.rmtree(place, ignore_errors=True)
        else:
            return FileError(
                f"{path} cannot be written ({error.strerror or error}), so its files were saved in "
                f"{place}: move them to another folder"
            )
    return error


def displaced_folder(path: Path) -> Path | None:
    """Return where the old contents of ``path`` are if a writer was killed while replacing it.

    Return None if ``path`` exists or has no old contents.
    """
    path = resolved(path)
    if path.exists() or not path.parent.is_dir():
        return None
    return max(
        _abandoned_folders(path, "old"), key=lambda old: old.lstat().st_ctime_ns, default=None
    )


def write_text(path: Path, text: str) -> None:
    """Write a UTF-8 text file atomically."""
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def write_json(path: Path, tree: Any) -> None:
    """Write a JSON file atomically. Raise ValueError for NaN, which JSON cannot express."""
    write_text(path, json.dumps(tree, indent=2, allow_nan=False) + "\n")


def _abandoned_folders(path: Path, kind: str) -> list[Path]:
    """Return the folders next to ``path`` that writers of ``path`` left behind.

    For ``kind`` "part" these are temporary folders, and for "old" folders with replaced contents.
    """
    name = re.compile(rf"\.{re.escape(path.name)}\.[0-9a-f]{{8}}\.{kind}")
    return [entry for entry in path.parent.iterdir() if name.fullmatch(entry.name)]


def _create_locked_folder(path: Path) -> tuple[Path, int]:
    """Create and lock a temporary folder next to ``path``.

    Return the folder and the file descriptor of the lock.
    """
    while True:
        folder = path.with_name(f".{path.name}.{uuid4().hex[:8]}.part")
        folder.mkdir()
        with suppress(FileNotFoundError):  # another writer removed it before this one locked it
            lock = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
            with suppress(OSError):  # the disk has no locks: no other writer can remove it either
                fcntl.flock(lock, fcntl.LOCK_EX)
            if folder.exists():
                return folder, lock
            os.close(lock)


def _remove_if_dead(folder: Path) -> None:
    with suppress(OSError):  # a running writer has locked it, or this process may not remove it
        lock = os.open(folder, os.O_RDONLY | os.O_CLOEXEC | os.O_DIRECTORY | os.O_NOFOLLOW)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
        finally:
            os.close(lock)


def _check_replaceable(path: Path) -> None:
    if path.exists() and not path.is_dir():
        raise FileError(f"{path} is a file: choose a folder")
    if path.is_mount():
        raise FileError(f"{path} is a mounted disk and cannot be replaced: choose a folder in it")
    with suppress(FileNotFoundError):  # the working folder may have been removed
        if path.exists() and Path.cwd().is_relative_to(path):
            raise FileError(
                f"{path} is the working folder and cannot be replaced: "
                "choose another folder, or run the command from elsewhere"
            )


def _swap(path: Path, new: Path) -> None:
    for file in (*new.rglob("*"), new):
        _flush(file)  # otherwise the rename may reach the disk before the contents
    if path.exists():
        shutil.copymode(path, new)
    try:
        new.rename(path)  # the target does not exist, or is an empty folder
        return
    except OSError as error:
        if error.errno not in _NOT_EMPTY:
            raise
    old = path.with_name(f".{path.name}.{uuid4().hex[:8]}.old")
    try:
        path.rename(old)
        new.rename(path)
    except BaseException:
        if old.exists() and not path.exists():
            old.rename(path)
        raise
    _flush(path.parent)
    shutil.rmtree(old, ignore_errors=True)


def _flush(path: Path) -> None:
    number = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(number)
    finally:
        os.close(number)
