"""Raw scans as bytes: what a fingertip without a fingertip is fed with.

A record is one scan, six little-endian uint16 (12 bytes) in the order of
:data:`firstcontact.twin.sensor.SCAN`, and nothing between two records.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.errors import InputError
from firstcontact.core.files import replacing
from firstcontact.twin.sensor import SCAN

#: Length of a record, bytes.
RECORD_BYTES = 2 * len(SCAN)


def scan_bytes(scans: NDArray[np.uint16]) -> bytes:
    """Scans, shape (n, 6), as n records."""
    return np.ascontiguousarray(scans, dtype="<u2").tobytes()


def write_scans(path: Path, blocks: Iterable[NDArray[np.uint16]]) -> None:
    """Write blocks of scans, each of shape (n, 6), one after the other."""
    with replacing(path) as temporary, temporary.open("wb") as stream:
        for block in blocks:
            stream.write(scan_bytes(block))


def read_scans(path: Path) -> NDArray[np.uint16]:
    """All scans of a file, shape (n, 6).

    Raises
    ------
    InputError
        It cannot be read, or does not end with a whole record.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}): give a file of scans"
        ) from error
    if len(data) % RECORD_BYTES:
        raise InputError(
            f"{path} does not end with a whole record of {RECORD_BYTES} bytes: write it again"
        )
    return np.frombuffer(data, dtype="<u2").astype(np.uint16).reshape(-1, len(SCAN))
