"""A serial port as a way for bytes, and frames to the device."""

from __future__ import annotations

import errno
import os
import select
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

from firstcontact.core import InputError
from firstcontact.device._protocol import FrameType, encode

#: Longest wait of a read, s: how soon a stop is noticed.
PATIENCE = 0.05
#: Most bytes of a read.
MOST = 65_536
#: Longest wait of a write, s: a device that takes nothing is gone.
WRITE = 1.0
#: A USB port has no speed of its own; a UART bridge must be told one that is enough:
#: samples take 176 kB/s, and start and stop bits a quarter more.
BAUD = 4_000_000


#: What opening a port may raise; pyserial's own exception is an OSError.
FAULTS: tuple[type[Exception], ...] = (OSError, ValueError)
with suppress(ImportError):  # not on Windows
    import termios

    # A terminal that goes while it is opened; no OSError.
    FAULTS += (termios.error,)


class LinkError(OSError):
    """The port is gone; it may come back."""


class SerialTransport:
    """An open serial port, for this process alone.

    It is locked before anything about it is changed, so that whoever has it open is not
    disturbed. One thread may read; :meth:`send` may be called from any.

    Parameters
    ----------
    port
        Its path or name.

    Raises
    ------
    InputError
        It is not there, is in use, or may not be opened.
    """

    def __init__(self, port: str) -> None:
        import serial

        self.port = port
        self._counter = 0
        self._sending = threading.Lock()
        try:
            self._serial: Any = serial.Serial(
                port, BAUD, timeout=PATIENCE, write_timeout=WRITE, exclusive=True
            )
        except FAULTS as error:
            raise InputError(why_not(port, error)) from error

    def read(self) -> bytes:
        """All that is there, or the first that comes within :data:`PATIENCE`; b"" if nothing.

        Raises
        ------
        LinkError
            The port is gone.
        """
        try:
            return self._read() if os.name == "posix" else self._read_portably()
        except (OSError, TypeError, ValueError) as error:  # a closed port has no descriptor
            raise LinkError(f"{self.port}: {error}") from error

    def _read(self) -> bytes:
        """As pyserial would, at a fifth less of all that a block costs the host."""
        number = self._serial.fileno()
        ready, _, _ = select.select([number], [], [], PATIENCE)
        if not ready:
            return b""
        data = os.read(number, MOST)
        if not data:
            raise LinkError("it has hung up")
        return data

    def _read_portably(self) -> bytes:
        data: bytes = self._serial.read(1)
        # What came with the first byte; waiting for a full buffer would be a delay.
        return data + self._serial.read(self._serial.in_waiting) if data else data

    def send(self, kind: FrameType, payload: bytes = b"") -> None:
        """Send a frame.

        Raises
        ------
        LinkError
            The port is gone or takes nothing.
        """
        with self._sending:
            try:
                self._serial.write(encode(kind, self._counter, payload))
            except (OSError, TypeError) as error:
                raise LinkError(f"{self.port}: {error}") from error
            self._counter += 1

    def close(self) -> None:
        """Let go of the port. Closing twice is fine."""
        # Not while a frame goes out: its rest would go to whatever has the number next.
        with self._sending, suppress(OSError):
            self._serial.close()


def why_not(port: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.ENOENT:
        return f"{port}: there is no such port: see `firstcontact ports`, or use --device twin"
    if number in (errno.EACCES, errno.EPERM):
        return (
            f"{port}: you may not open this port: add yourself to its group (on Debian: "
            "`sudo adduser $USER dialout`) and log in again"
        )
    if number in (errno.EAGAIN, errno.EBUSY):
        return f"{port}: another program has this port open: close that one first"
    other = no_port(port)
    return other or f"{port}: cannot be opened as a serial port ({error}): see `firstcontact ports`"


def no_port(port: str) -> str:
    """Why a path can be no port, whatever it holds; "" where it may be one."""
    if Path(port).is_dir():
        return f"{port} is a folder: name one recording in it (*.mcap), or a port"
    if Path(port).is_file():
        return (
            f"{port} is a file and not a port: make a recording of it with `firstcontact import`, "
            "and name that (*.mcap)"
        )
    return ""
