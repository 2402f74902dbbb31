"""Whatever many jobs need, as one array: shared by reference, not sent with every job."""

from __future__ import annotations

import pickle
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

#: Places of arrays are multiples of it, bytes, as processors like them.
ALIGNMENT = 64

_opened: tuple[bytes, tuple[Any, ...]] = (b"", ())


def pack_payload(values: tuple[Any, ...]) -> NDArray[np.uint8]:
    """One array that holds the values, and of their own arrays the samples side by side.

    An array is what joblib maps into the memory of all processes of a machine, and what travels
    once to each machine of a cluster. It goes from one running program to its own workers and is
    never a file of a user's.
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
    """The values; their arrays lie in this one and are read-only. The last are remembered."""
    global _opened
    key = array[:16].tobytes()
    if _opened[0] != key:
        count = int.from_bytes(array[16:24].tobytes(), "little")
        sizes = np.frombuffer(array[24 : 24 + 8 * count].tobytes(), dtype=np.int64)
        whole = array.data.toreadonly()
        head, *buffers = (
            whole[place : place + size]
            for place, size in zip(_places(24 + 8 * count, sizes), sizes, strict=True)
        )
        _opened = key, pickle.loads(head, buffers=buffers)  # noqa: S301  # made above, by us
    return _opened[1]


def _places(begin: int, sizes: NDArray[np.int64]) -> list[int]:
    places = []
    for size in sizes:
        begin = -(-begin // ALIGNMENT) * ALIGNMENT
        places.append(begin)
        begin += int(size)
    return places
