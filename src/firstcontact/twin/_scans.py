"""Files of raw ADC scans that feed the emulated firmware.

A record is one scan: six little-endian uint16 (12 bytes) in the order of
:data:`firstcontact.twin._sensor.SCAN`. Records follow each other without separators.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import replacing


def scan_bytes(scans: NDArray[np.uint16]) -> bytes:
    """Return scans, shape (n, 6), as the bytes of n records."""
    return np.ascontiguousarray(scans, dtype="<u2").tobytes()


def write_scans(path: Path, blocks: Iterable[NDArray[np.uint16]]) -> None:
    """Write blocks of scans, each of shape (n, 6), one after another."""
    with replacing(path) as temporary, temporary.open("wb") as stream:
        for block in blocks:
            stream.write(scan_bytes(block))
