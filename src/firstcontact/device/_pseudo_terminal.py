"""The device's end of a pseudo terminal: a serial port with no wire."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: How the folders of ports begin, in that of temporary files.
PREFIX = "firstcontact-port-"
#: A folder so old is locked if anybody uses it, s.
NEW = 60.0


@contextmanager
def port_folder() -> Iterator[Path]:
    """A folder for a port's name, until the end of the block.

    Where a program is killed its folder stays: the next one sweeps it away.
    """
    place = Path(tempfile.gettempdir())
    for old in place.glob(f"{PREFIX}*"):
        _sweep(old)
    with tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True) as name:
        lock = os.open(name, os.O_RDONLY | os.O_CLOEXEC)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield Path(name)
        finally:
            os.close(lock)


def _sweep(folder: Path) -> None:
    """Remove the folder of a program that is no more."""
    # What is somebody else's, or is gone meanwhile, is left alone.
    with suppress(OSError):
        lock = os.open(folder, os.O_RDONLY | os.O_CLOEXEC | os.O_DIRECTORY | os.O_NOFOLLOW)
        try:
            status = os.fstat(lock)
            if status.st_uid != os.getuid() or time.time() - status.st_mtime < NEW:
                return
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
        finally:
            os.close(lock)


class PseudoTerminal:
    """A terminal that a host opens like a serial port, under a name that stays.

    Parameters
    ----------
    path
        A symbolic link to make; its folder must exist. It is there while the
        terminal is plugged in.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._device = self._host = -1
        self.plug()

    @property
    def plugged(self) -> bool:
        """Whether a host can open it."""
        return self._device >= 0

    def plug(self) -> None:
        """Make the terminal; nothing where it is there."""
        if self.plugged:
            return
        self._device, self._host = os.openpty()
        # Before a host opens it: no echo, nothing turned into anything else. It stays so
        # while the host's side is held open here, and no host that leaves ends the terminal.
        tty.setraw(self._host)
        os.set_blocking(self._device, False)
        self.path.symlink_to(os.ttyname(self._host))

    def unplug(self) -> None:
        """Take the terminal away under whoever has it open; nothing where it is gone."""
        if not self.plugged:
            return
        with suppress(FileNotFoundError):
            self.path.unlink()
        os.close(self._host)
        os.close(self._device)
        self._device = self._host = -1

    def fileno(self) -> int:
        """For ``select``; -1 while unplugged."""
        return self._device

    def read(self) -> bytes:
        """What the host has sent, b"" where nothing."""
        try:
            return os.read(self._device, 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> int:
        """Send what fits, and tell how much that was."""
        try:
            return os.write(self._device, data)
        except BlockingIOError:
            return 0
