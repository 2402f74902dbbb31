"""How much a compressed file may unpack to."""

from __future__ import annotations

from pathlib import Path

from firstcontact.core import InputError

#: Bytes that any file may unpack to, and times its own size beyond that. Samples of sensors
#: shrink to a third at best; a file that is made to fill the memory shrinks a thousandfold.
UNPACKED_BYTES = 64 << 20
UNPACKED_TIMES = 100


def most_unpacked(size: int) -> int:
    """Bytes that a file of a size may unpack to."""
    return UNPACKED_BYTES + UNPACKED_TIMES * size


def check_unpacked(path: Path, declared: int) -> None:
    """Refuse a file that declares more than it can honestly hold, before it is unpacked.

    Raises
    ------
    InputError
        It does.
    OSError
        It is not there.
    """
    size = path.stat().st_size
    if declared > most_unpacked(size):
        raise InputError(
            f"{path} has {size} bytes and declares {declared} to be unpacked, more than "
            f"{UNPACKED_BYTES >> 20} MiB and {UNPACKED_TIMES} times its size: save it without "
            "compression"
        )
