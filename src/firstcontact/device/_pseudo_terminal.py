"""Device side of a pseudo terminal, which acts as a serial port without a wire."""

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

#: Prefix of the folders for ports, inside the folder of temporary files.
PREFIX = "firstcontact-port-"
#: Age above which an unlocked folder counts as unused, s.
NEW = 60.0


@contextmanager
def port_folder() -> Iterator[Path]:
    """Create a temporary folder for a port's name, for the duration of a ``with`` block.

    If the program is killed, its folder stays until another program calls this function.
    """
    parent = Path(tempfile.gettempdir())
    for old in parent.glob(f"{PREFIX}*"):
        _sweep(old)
    with tempfile.TemporaryDirectory(prefix=PREFIX, ignore_cleanup_errors=True) as name:
        lock = os.open(name, os.O_RDONLY | os.O_CLOEXEC)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield Path(name)
        finally:
            os.close(lock)


def _sweep(folder: Path) -> None:
    """Remove the folder of a program that has ended."""
    # Ignore folders of other users and folders that vanished meanwhile.
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
    """Terminal that a host opens like a serial port, under a stable name.

    Parameters
    ----------
    path
        Symbolic link to create, in an existing folder. It exists while the terminal is plugged in.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._device = self._host = -1
        self.plug()

    @property
    def plugged(self) -> bool:
        """Return True if a host can open the terminal."""
        return self._device >= 0

    def plug(self) -> None:
        """Create the terminal unless it exists."""
        if self.plugged:
            return
        self._device, self._host = os.openpty()
        # Set raw mode before a host opens the terminal: no echo, no translation. The open host side
        # keeps this mode and keeps the terminal alive when a host leaves.
        tty.setraw(self._host)
        os.set_blocking(self._device, False)
        self.path.symlink_to(os.ttyname(self._host))

    def unplug(self) -> None:
        """Remove the terminal, even while a host has it open. Do nothing while it is unplugged."""
        if not self.plugged:
            return
        with suppress(FileNotFoundError):
            self.path.unlink()
        os.close(self._host)
        os.close(self._device)
        self._device = self._host = -1

    def fileno(self) -> int:
        """Return the file descriptor for ``select``; -1 while unplugged."""
        return self._device

    def read(self) -> bytes:
        """Return the bytes that the host sent; b"" if none."""
        try:
            return os.read(self._device, 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> int:
        """Send as many bytes as fit. Return their number."""
        try:
            return os.write(self._device, data)
        except BlockingIOError:
            return 0
