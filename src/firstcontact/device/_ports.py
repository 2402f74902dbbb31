"""Serial ports of this machine, and their access rights."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

#: USB vendor number of PJRC's Teensy boards.
TEENSY = 0x16C0


@dataclass(frozen=True, slots=True)
class Port:
    """One serial port."""

    name: str
    description: str
    teensy: bool


def ports() -> list[Port]:
    """Return the serial ports, those that look like a Teensy first."""
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
    """Return owner, group and mode of a port, and whether this process may open it."""
    try:
        state = path.stat()
    except OSError as error:
        return f"missing ({error.strerror})"
    mode = f"{state.st_mode & 0o777:03o}"
    may = "may" if os.access(path, os.R_OK | os.W_OK) else "may NOT"
    return f"{_user(state.st_uid)}:{_group(state.st_gid)} {mode}, this user {may} open it"


def groups() -> list[str]:
    """Return the names of this process's groups; none on systems without groups."""
    if os.name != "posix":
        return []
    return sorted(_group(number) for number in {*os.getgroups(), os.getegid()})


def _user(number: int) -> str:
    try:
        import pwd

        return pwd.getpwuid(number).pw_name
    except (ImportError, KeyError):
        return str(number)


def _group(number: int) -> str:
    try:
        import grp

        return grp.getgrgid(number).gr_name
    except (ImportError, KeyError):
        return str(number)
