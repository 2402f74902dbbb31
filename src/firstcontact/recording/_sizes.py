"""Limits on the unpacked size of compressed files."""

from __future__ import annotations

from pathlib import Path

from firstcontact.core import InputError

#: Unpacked size that any file may have, bytes, and largest ratio to its own size beyond that.
#: Sensor samples shrink to a third at best; a malicious file shrinks a thousandfold.
UNPACKED_BYTES = 64 << 20
UNPACKED_TIMES = 100


def most_unpacked(size: int) -> int:
    """Return the largest allowed unpacked size of a file of ``size`` bytes, bytes."""
    return UNPACKED_BYTES + UNPACKED_TIMES * size


def check_unpacked(path: Path, declared: int) -> None:
    """Raise an error for a file that declares an impossible size, before it is unpacked."""
    size = path.stat().st_size
    if declared > most_unpacked(size):
        raise InputError(
            f"{path} has {size} bytes and declares {declared} unpacked bytes, more than "
            f"{UNPACKED_BYTES >> 20} MiB and {UNPACKED_TIMES} times its size: save it without "
            "compression"
        )
