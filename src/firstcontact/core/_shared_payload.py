"""Data that many jobs share, packed into one array and sent once."""

from __future__ import annotations

import pickle
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

#: Alignment of packed arrays, bytes.
ALIGNMENT = 64

_opened: tuple[bytes, tuple[Any, ...]] = (b"", ())


def pack_payload(values: tuple[Any, ...]) -> NDArray[np.uint8]:
    """Pack values into one array, which holds their own arrays uncompressed.

    Joblib maps an array into the memory of all processes on a machine. A cluster sends it once to
    each machine. The array goes only from a program to its own workers and is never a user's file.
    """
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(values, protocol=5, buffer_callback=buffers.append)
    parts: list[Any] = [head, *(buffer.raw() for buffer in buffers)]
    sizes = np.array([len(part) for part in parts], dtype=np.int64)
    begin = uuid4().bytes + len(sizes).to_bytes(8, "little") + sizes.tobytes()
    places = _places(len(begin), sizes)
    out = np.zeros(places[-1] + sizes[-1], dtype=np.uint8)
    out[: len(begin)] = np.frombuffer(begin, dtype=np.uint8)
    for place, part in zip(places, parts, strict=True):
        out[place : place + len(part)] = np.frombuffer(part, dtype=np.uint8)
    return out


def unpack_payload(array: NDArray[np.uint8]) -> tuple[Any, ...]:
    """Return the packed values with read-only arrays. The last payload is cached."""
    global _opened
    key = array[:16].tobytes()
    if _opened[0] != key:
        count = int.from_bytes(array[16:24].tobytes(), "little")
        sizes = np.frombuffer(array[24 : 24 + 8 * count].tobytes(), dtype=np.int64)
        view = array.data.toreadonly()
        head, *buffers = (
            view[place : place + size]
            for place, size in zip(_places(24 + 8 * count, sizes), sizes, strict=True)
        )
        _opened = key, pickle.loads(head, buffers=buffers)  # noqa: S301  # packed by this program
    return _opened[1]


def _places(begin: int, sizes: NDArray[np.int64]) -> list[int]:
    places = []
    for size in sizes:
        begin = -(-begin // ALIGNMENT) * ALIGNMENT
        places.append(begin)
        begin += int(size)
    return places
