"""Serial port for bytes, and for frames to the device."""

from __future__ import annotations

import errno
import os
import select
import threading
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

from firstcontact.core import InputError
from firstcontact.device._protocol import FrameType, encode

#: Longest wait of a read, s. It limits the time until a stop is noticed.
PATIENCE = 0.05
#: Largest number of bytes of a read.
MOST = 65_536
#: Longest wait of a write, s. A device that does not read for so long is gone.
WRITE = 1.0
#: Baud rate, for UART bridges only; USB ports ignore it. Samples take 176 kB/s, and start and stop
#: bits a quarter more.
BAUD = 4_000_000


#: Errors from opening a port; pyserial's own exception is an OSError.
FAULTS: tuple[type[Exception], ...] = (OSError, ValueError)
with suppress(ImportError):  # not on Windows
    import termios

    # A terminal that vanishes during opening raises this error, which is not an OSError.
    FAULTS += (termios.error,)


class LinkError(OSError):
    """Error for a port that has vanished. It may come back."""


class SerialTransport:
    """Open serial port, locked for this process."""

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
            raise InputError(opening_error(port, error)) from error

    def read(self, patience: float = PATIENCE) -> bytes:
        """Return the available bytes. Wait at most ``patience`` s for the first."""
        try:
            patience = min(patience, PATIENCE)
            return self._read(patience) if os.name == "posix" else self._read_portably(patience)
        except (OSError, TypeError, ValueError) as error:  # a closed port has no file descriptor
            raise LinkError(f"{self.port}: {error}") from error

    def _read(self, patience: float) -> bytes:
        """Return the available bytes like pyserial, with about 20 % less work for the processor."""
        number = self._serial.fileno()
        ready, _, _ = select.select([number], [], [], patience)
        if not ready:
            return b""
        data = os.read(number, MOST)
        if not data:
            raise LinkError("the other end closed the port")
        return data

    def _read_portably(self, patience: float) -> bytes:
        if self._serial.timeout != patience:
            self._serial.timeout = patience
        data: bytes = self._serial.read(1)
        # Read the bytes that came with the first one. Waiting for a full buffer would add latency.
        return data + self._serial.read(self._serial.in_waiting) if data else data

    def send(self, kind: FrameType, payload: bytes = b"") -> None:
        """Send a frame."""
        with self._sending:
            try:
                self._write(encode(kind, self._counter, payload))
            except (OSError, TypeError, ValueError) as error:
                raise LinkError(f"{self.port}: {error}") from error
            self._counter += 1

    def _write(self, data: bytes) -> None:
        if os.name != "posix":
            self._serial.write(data)
            return
        # pyserial also fails if this process was stopped for WRITE, although the port takes bytes.
        number, waited = self._serial.fileno(), 0.0
        while data:
            began = time.monotonic()
            if select.select([], [number], [], PATIENCE)[1]:
                with suppress(BlockingIOError):
                    data = data[os.write(number, data) :]
            waited += min(time.monotonic() - began, PATIENCE)
            if data and waited >= WRITE:
                raise LinkError("it accepts no bytes")

    def close(self) -> None:
        """Release the port. Closing twice is fine."""
        # Wait until a frame is sent. Otherwise its remainder could go to the next file with this
        # descriptor.
        with self._sending, suppress(OSError):
            self._serial.close()


def opening_error(port: str, error: Exception) -> str:
    """Return the reason why a port could not be opened, and the remedy."""
    code = getattr(error, "errno", None)
    if code == errno.ENOENT:
        return f"{port}: there is no such port: see `firstcontact ports`, or use --device twin"
    if code in (errno.EACCES, errno.EPERM):
        return (
            f"{port}: you may not open this port: add yourself to its group (on Debian: "
            "`sudo adduser $USER dialout`) and log in again"
        )
    if code in (errno.EAGAIN, errno.EBUSY):
        return f"{port}: another program has this port open: close that program first"
    other = not_a_port(port)
    return other or f"{port}: cannot be opened as a serial port ({error}): see `firstcontact ports`"


def not_a_port(port: str) -> str:
    """Return the reason why a path cannot be a port; "" if it can."""
    if Path(port).is_dir():
        return f"{port} is a folder: name one recording in it (*.mcap), or a port"
    if Path(port).is_file():
        return (
            f"{port} is a file and not a port: make a recording of it with `firstcontact import`, "
            "and name that (*.mcap)"
        )
    return ""
