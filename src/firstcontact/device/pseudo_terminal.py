"""The device's end of a pseudo terminal: a serial port with no wire."""

from __future__ import annotations

import os
import tty
from contextlib import suppress
from pathlib import Path


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
