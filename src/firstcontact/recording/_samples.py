"""Message that contains a block. It is encoded as ROS 2 CDR, so that viewers can plot it.

Byte layout, little-endian, after the 4-byte encapsulation header ``00 01 00 00``:

======  ======  =================================================
offset  type    field
======  ======  =================================================
0       uint64  first_sample
8       uint32  epoch
12      uint16  channels
14      2 x 0   (CDR alignment)
16      uint32  number of values (samples times channels)
20      array   values, one sample after the other
======  ======  =================================================
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block
from firstcontact.recording._header import DTYPES

#: Largest float sample: its squares and sums stay finite in 32 bits.
LARGEST = 1e12
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"
_PREFIX = struct.Struct("<4sQIHxxI")


def schema(dtype: str) -> bytes:
    """Return the ros2msg schema for samples of type ``dtype``: "int16", "int32" or "float32"."""
    return f"uint64 first_sample\nuint32 epoch\nuint16 channels\n{dtype}[] data\n".encode()


def encode(block: Block, dtype: str) -> bytes:
    """Return a block as a CDR message. The block's data must already have the type ``dtype``."""
    values = np.ascontiguousarray(block.data, dtype=DTYPES[dtype])
    channels = values.shape[1]
    prefix = _PREFIX.pack(
        _CDR_LITTLE_ENDIAN, block.first_sample, block.epoch, channels, values.size
    )
    return prefix + values.tobytes()


def decode(message: bytes, dtype: str) -> Block:
    """Return the block in a message of :func:`encode`. Its data are a view of ``message``."""
    if len(message) < _PREFIX.size:
        raise ValueError("a message with samples is too short")
    kind, first_sample, epoch, channels, count = _PREFIX.unpack_from(message)
    values: NDArray[np.generic] = np.frombuffer(message, DTYPES[dtype], offset=_PREFIX.size)
    if kind != _CDR_LITTLE_ENDIAN or not channels or values.size != count or count % channels:
        raise ValueError(
            "the length of a message with samples does not fit the numbers that it declares"
        )
    return Block(values.reshape(-1, channels), first_sample, epoch)
