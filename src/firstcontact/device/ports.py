"""Serial ports of this computer, and pseudo terminals that act as ports."""

from __future__ import annotations

import errno
import grp
import itertools
import logging
import os
import pwd
import select
import tempfile
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firstcontact.core import DeviceError, InputError
from firstcontact.device.protocol import FrameType, encode

#: USB vendor number of PJRC's Teensy boards.
TEENSY = 0x16C0
#: Longest wait of a read, s. It limits the time until a stop is noticed.
PATIENCE = 0.05
#: Largest number of bytes of a read.
MOST = 65_536
#: Longest wait of a write, s. A device that does not read for so long is gone.
WRITE = 1.0
#: Baud rate, for UART bridges only; USB ports ignore it. Samples take 176 kB/s, and start and stop
#: bits a quarter more.
BAUD = 4_000_000
#: Waits between attempts to open a port that is gone, s, and number of them after which its user is
#: told what to do.
RETRY, ANOTHER_NAME = 0.2, 15
#: Errors from opening a port. A terminal that vanishes meanwhile raises ``termios.error``.
_FAULTS = (OSError, ValueError, termios.error)

_log = logging.getLogger("firstcontact.device")


class LinkError(OSError):
    """Error for a serial port that vanished while open. The device may be plugged in again."""


class SerialTransport:
    """Open serial port for the frames of the protocol. No other process can open it meanwhile.

    Raises DeviceError, with a remedy, if the port cannot be opened.
    """

    def __init__(self, port: str, baud: int = BAUD) -> None:
        import serial

        self.port = port
        #: Names of the ports beside this one when it was opened.
        self.others = port_names(port)
        self._counter = 0
        self._sending = threading.Lock()
        try:
            self._serial: Any = serial.Serial(
                port, baud, timeout=PATIENCE, write_timeout=WRITE, exclusive=True
            )
        except _FAULTS as error:
            raise DeviceError(_opening_error(port, error)) from error

    def read(self, patience: float = PATIENCE) -> bytes:
        """Return the available bytes. Wait at most ``patience`` s for the first one.

        Return b"" if none came. Raise LinkError if the port has vanished.
        """
        try:
            # pyserial takes about 20 % more time of the processor.
            number = self._serial.fileno()
            if not select.select([number], [], [], min(patience, PATIENCE))[0]:
                return b""
            data = os.read(number, MOST)
        except (OSError, TypeError, ValueError) as error:  # a closed port has no file descriptor
            raise LinkError(f"{self.port}: {error}") from error
        if not data:
            raise LinkError(f"{self.port}: the device closed the port: plug it in again")
        return data

    def send(self, kind: FrameType, payload: bytes = b"") -> None:
        with self._sending:
            try:
                self._write(encode(kind, self._counter, payload))
            except (OSError, TypeError, ValueError) as error:
                raise LinkError(f"{self.port}: {error}") from error
            self._counter += 1

    def _write(self, data: bytes) -> None:
        # pyserial also fails if this process was stopped for WRITE, although the port takes bytes.
        number, waited = self._serial.fileno(), 0.0
        while data:
            began = time.monotonic()
            if select.select([], [number], [], PATIENCE)[1]:
                with suppress(BlockingIOError):
                    data = data[os.write(number, data) :]
            waited += min(time.monotonic() - began, PATIENCE)
            if data and waited >= WRITE:
                raise LinkError("it accepts no bytes: plug it in again")

    def close(self) -> None:
        # Wait until a frame is sent. Otherwise its remainder could go to the next file with this
        # descriptor.
        with self._sending, suppress(OSError):
            self._serial.close()


def reopen(lost: SerialTransport, closing: threading.Event, baud: int) -> SerialTransport | None:
    """Wait until a lost port is back, and return it open; None if ``closing`` is set first.

    If the port does not come back soon, or if another port appears, log a remedy.
    """
    waits, said = itertools.count(), lost.others
    while not closing.wait(RETRY):
        # The port may be missing, not accessible yet, or in use by another program.
        with suppress(InputError):
            return SerialTransport(lost.port, baud)
        new = port_names(lost.port) - said
        said |= new
        if new or next(waits) == ANOTHER_NAME:
            _log.warning(
                "%s is gone%s: if the device came back under another name, start again with that "
                "one (see `firstcontact ports`), or with /dev/serial/by-id/..., which stays",
                lost.port,
                f", and {', '.join(sorted(new))} is new" if new else "",
            )
    return None


def port_names(port: str) -> set[str]:
    """Return the other ports that exist whose names differ from ``port`` only in digits."""
    path = Path(port)
    return {str(p) for p in path.parent.glob(f"{path.name.rstrip('0123456789')}[0-9]*")} - {port}


def _opening_error(port: str, error: Exception) -> str:
    code = error.errno if isinstance(error, OSError) else None
    if code == errno.ENOENT:
        return f"there is no port {port}: see `firstcontact ports`"
    if code in (errno.EACCES, errno.EPERM):
        return (
            f"you may not open the port {port}: add yourself to its group (on Debian: "
            "`sudo adduser $USER dialout`) and log in again"
        )
    if code in (errno.EAGAIN, errno.EBUSY):
        return f"another program has the port {port} open: close that program first"
    other = not_a_port(port)
    return other or f"{port} cannot be opened as a serial port ({error}): see `firstcontact ports`"


def not_a_port(port: str) -> str:
    """Return a message if a path is a folder or file and so not a serial port; "" otherwise."""
    if Path(port).is_dir():
        return f"{port} is a folder: name one recording in it (*.mcap), or a port"
    if Path(port).is_file():
        return (
            f"{port} is a file and not a port: make a recording of it with `firstcontact import`, "
            "and name that (*.mcap)"
        )
    return ""


@dataclass(frozen=True, slots=True)
class Port:
    name: str
    description: str
    teensy: bool


def ports() -> list[Port]:
    from serial.tools import list_ports

    serial_ports = []
    for info in list_ports.comports():
        teensy = info.vid == TEENSY
        words = [info.description if info.description not in ("n/a", None) else "serial port"]
        if info.vid is not None:
            words.append(f"USB {info.vid:04X}:{info.pid:04X}")
        if teensy:
            words.append("looks like a Teensy")
        serial_ports.append(Port(info.device, ", ".join(words), teensy))
    return sorted(serial_ports, key=lambda port: (not port.teensy, port.name))


def access(path: Path) -> str:
    """Return a text with a port's owner, group and mode, and if this user may open the port."""
    try:
        state = path.stat()
    except OSError as error:
        return f"missing ({error.strerror})"
    mode = f"{state.st_mode & 0o777:03o}"
    may = "may" if os.access(path, os.R_OK | os.W_OK) else "may NOT"
    owner = f"{_name(pwd.getpwuid, state.st_uid)}:{_name(grp.getgrgid, state.st_gid)}"
    return f"{owner} {mode}, this user {may} open it"


def groups() -> list[str]:
    return sorted(_name(grp.getgrgid, number) for number in {*os.getgroups(), os.getegid()})


def _name(find: Callable[[int], Any], number: int) -> str:
    try:
        return str(find(number)[0])
    except KeyError:
        return str(number)


@contextmanager
def port_folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="firstcontact-port-") as name:
        yield Path(name)


class PseudoTerminal:
    """Simulated serial port, which a host opens through the symbolic link ``path``."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._device = self._host = -1
        self.plug()

    @property
    def plugged(self) -> bool:
        return self._device >= 0

    def plug(self) -> None:
        if self.plugged:
            return
        self._device, self._host = os.openpty()
        # Set raw mode before a host opens the terminal: no echo, no translation. The open host side
        # keeps this mode and keeps the terminal alive when a host leaves.
        tty.setraw(self._host)
        os.set_blocking(self._device, False)
        self.path.symlink_to(os.ttyname(self._host))

    def unplug(self) -> None:
        """Remove the port, even while a host has it open. A second call does nothing."""
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
        """Return the bytes that the host has sent since the last call; b"" if there are none."""
        try:
            return os.read(self._device, 4096)
        except BlockingIOError:
            return b""

    def write(self, data: bytes) -> int:
        try:
            return os.write(self._device, data)
        except BlockingIOError:
            return 0
