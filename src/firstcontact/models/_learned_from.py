"""Digests that identify training pinches by their samples, not by names.

Eight bytes of BLAKE2b of the piezo signals in V, as float32: they are the same for a
recording, for its copy under other names, and for what was exported from it whole and
imported again. Pinches that were resampled, filtered, scaled or cut otherwise have other
digests, and so do those of another sensor's channels.
"""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import blake2b
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import InputError, Pinch, read_verified

Digests = NDArray[np.uint64]

#: Of a digest, bytes. Among 100,000 by 100,000 pinches one in a billion runs finds a false match.
SIZE = 8
#: Longest file of digests that is read, bytes.
LONGEST = SIZE * 10_000_000
#: Where a model's folder keeps them, ascending, little-endian.
FILE = "pinches.bin"


def pinch_digests(pinches: Sequence[Pinch]) -> Digests:
    """Digest of each pinch, shape (pinches,)."""
    return np.array([_digest(pinch) for pinch in pinches], dtype=np.uint64)


def _digest(pinch: Pinch) -> int:
    with np.errstate(over="ignore"):
        volts = pinch.vibration().astype("<f4")
    volts += np.float32(0.0)  # -0 and 0 are the same voltage
    shape = np.array(volts.shape, dtype="<u8").tobytes()
    hashed = blake2b(shape + volts.tobytes(), digest_size=SIZE).digest()
    return int.from_bytes(hashed, "little")


def to_bytes(digests: Digests) -> bytes:
    """Return digests as bytes of a file."""
    return np.unique(digests).astype("<u8").tobytes()


def read_digests(path: Path, sha256: str, card: str) -> Digests:
    """Return the digests of a file, ascending, after its checksum.

    Raises
    ------
    InputError
        Missing, damaged, or another model's.
    """
    raw = read_verified(path, sha256, card, LONGEST)
    if len(raw) % SIZE:
        raise InputError(f"{path}: is cut off: copy the folder again")
    return np.frombuffer(raw, dtype="<u8").astype(np.uint64)
