"""Frames of the wire protocol of ``docs/protocol.md``, version 1, without I/O."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

VERSION = 1
#: Largest number of samples in a frame: 1 ms at 4936 Hz.
FRAME_SAMPLES = 5
#: Longest text of a marker or an order, bytes.
MARKER_BYTES = 200
#: Length limit of a stuffed frame, bytes. A descriptor of 100 channels fits.
LONGEST = 16_384
_HEAD = struct.Struct("<BI")
_CRC = struct.Struct("<I")
_SAMPLES = struct.Struct("<IIB")
_DESCRIPTOR = struct.Struct("<BI")
_STOPPED = struct.Struct("<II")
_MARKER = struct.Struct("<I")
_LATE = struct.Struct("<II")
_HINT = struct.Struct("<fff")


class FrameType(IntEnum):
    """Type of a frame, its first byte."""

    DESCRIPTOR = 0x01
    SAMPLES = 0x02
    MARKER = 0x03
    STOPPED = 0x04
    REFUSED = 0x05
    CONTACT = 0x06
    ESTIMATE = 0x07
    MODEL_STATE = 0x08
    LATE = 0x09
    WITHDRAWN = 0x0A
    HELLO = 0x81
    START = 0x82
    STOP = 0x83
    MARK = 0x84
    ORDER = 0x85
    MODEL_BEGIN = 0x86
    MODEL_CHUNK = 0x87
    MODEL_END = 0x88
    HINT = 0x89


class FrameError(ValueError):
    """Error for an invalid frame: bad length, stuffing, CRC or payload."""


class Frame(NamedTuple):
    """Decoded frame, without its CRC."""

    type: int
    counter: int
    payload: bytes


@dataclass(frozen=True, slots=True, eq=False)
class SamplesFrame:
    """Payload of a samples frame. ``data`` has shape (n, channels), int16."""

    first_sample: int
    overflow: int
    data: NDArray[np.int16]


def stuff(data: bytes) -> bytes:
    """Return ``data`` encoded with COBS: without zeros, and without the final zero of a frame."""
    out = bytearray()
    for run in data.split(b"\0"):
        # A run of 254 bytes or more is split into blocks without a zero in between.
        while len(run) >= 254:
            out += b"\xff" + run[:254]
            run = run[254:]
        out.append(len(run) + 1)
        out += run
    return bytes(out)


def unstuff(stuffed: bytes) -> bytes:
    """Decode COBS, the inverse of :func:`stuff`."""
    n = len(stuffed)
    if n == 0 or 0 in stuffed:
        raise FrameError("a frame is empty or contains a zero byte")
    out = bytearray(stuffed)
    place = 0
    full = []
    if n < 255:  # true for nearly all frames: no run is full
        while place < n:
            out[place] = 0
            place += stuffed[place]
    while place < n:
        code = stuffed[place]
        out[place] = 0
        place += code
        if code == 255 and place < n:
            full.append(place)
    if place != n:
        raise FrameError("a frame's byte stuffing points beyond the end of the frame")
    # A code after a full run represents no zero.
    for place in reversed(full):
        del out[place]
    return bytes(out[1:])


def encode(kind: int, counter: int, payload: bytes = b"") -> bytes:
    """Return a frame as sent, with its final zero."""
    body = _HEAD.pack(kind, counter & 0xFFFFFFFF) + payload
    return stuff(body + _CRC.pack(zlib.crc32(body))) + b"\0"


def decode(stuffed: bytes) -> Frame:
    """Return the frame in the bytes before its final zero."""
    body = unstuff(stuffed)
    if len(body) < _HEAD.size + _CRC.size:
        raise FrameError("a frame is too short")
    if _CRC.unpack_from(body, len(body) - _CRC.size)[0] != zlib.crc32(body[: -_CRC.size]):
        raise FrameError("a frame's checksum (CRC) does not match its content")
    kind, counter = _HEAD.unpack_from(body)
    return Frame(kind, counter, body[_HEAD.size : -_CRC.size])


def samples_payload(first_sample: int, overflow: int, data: NDArray[np.int16]) -> bytes:
    """Return the payload of a samples frame. ``data`` has shape (1 to 5, channels)."""
    head = _SAMPLES.pack(first_sample & 0xFFFFFFFF, overflow & 0xFFFFFFFF, len(data))
    return head + np.ascontiguousarray(data, dtype="<i2").tobytes()


def samples_head(payload: bytes, channels: int) -> tuple[int, int, int, bytes]:
    """Return the parts of a samples frame's payload, without decoding the samples."""
    if len(payload) < _SAMPLES.size:
        raise FrameError("a frame of type SAMPLES is too short")
    first, overflow, n = _SAMPLES.unpack_from(payload)
    data = payload[_SAMPLES.size :]
    if n < 1 or len(data) != 2 * n * channels:
        raise FrameError(
            f"a frame of type SAMPLES does not hold the {n} samples of {channels} channels that "
            "it declares"
        )
    return first, overflow, n, data


def read_samples(payload: bytes, channels: int) -> SamplesFrame:
    """Return the samples frame of a payload. Raise FrameError as :func:`samples_head` does."""
    first, overflow, n, data = samples_head(payload, channels)
    return SamplesFrame(first, overflow, np.frombuffer(data, dtype="<i2").reshape(n, channels))


def descriptor_payload(boot: int, text: str, version: int = VERSION) -> bytes:
    """Return the payload of a descriptor frame."""
    return _DESCRIPTOR.pack(version, boot) + text.encode()


def read_descriptor(payload: bytes) -> tuple[int, int, str]:
    """Return protocol version, boot number and text of a descriptor frame."""
    if len(payload) < _DESCRIPTOR.size:
        raise FrameError("a frame of type DESCRIPTOR is too short")
    version, boot = _DESCRIPTOR.unpack_from(payload)
    return version, boot, _text(payload[_DESCRIPTOR.size :])


def marker_payload(sample: int, text: str) -> bytes:
    """Return the payload of a marker frame. A long text is cut between characters."""
    return _MARKER.pack(sample & 0xFFFFFFFF) + marker_text(text)


def marker_text(text: str) -> bytes:
    """Return a marker's text as UTF-8, cut between characters to fit a frame."""
    return text.encode()[:MARKER_BYTES].decode(errors="ignore").encode()


def read_marker(payload: bytes) -> tuple[int, str]:
    """Return sample number (32 bits) and text of a marker frame. Raise FrameError if damaged."""
    if len(payload) < _MARKER.size:
        raise FrameError("a frame of type MARKER is too short")
    return int(_MARKER.unpack_from(payload)[0]), _text(payload[_MARKER.size :])


def stopped_payload(next_sample: int, overflow: int) -> bytes:
    """Return the payload of a stopped frame."""
    return _STOPPED.pack(next_sample & 0xFFFFFFFF, overflow & 0xFFFFFFFF)


def read_stopped(payload: bytes) -> tuple[int, int]:
    """Return the number of the next sample and the overflow count of a stopped frame."""
    if len(payload) != _STOPPED.size:
        raise FrameError("a frame of type STOPPED has the wrong length")
    next_sample, overflow = _STOPPED.unpack(payload)
    return next_sample, overflow


def late_payload(skipped: int, unheard: int) -> bytes:
    """Return the payload of a ``late`` frame. It counts skipped predictions and missed samples."""
    return _LATE.pack(skipped & 0xFFFFFFFF, unheard & 0xFFFFFFFF)


def read_late(payload: bytes) -> tuple[int, int]:
    """Return the counts of skipped predictions and missed samples in a ``late`` frame."""
    if len(payload) != _LATE.size:
        raise FrameError("a frame of type LATE (count of skipped estimates) has the wrong length")
    skipped, unheard = _LATE.unpack(payload)
    return skipped, unheard


def hint_payload(speed: float, error: float, radius: float) -> bytes:
    """Return the payload of a hint: closing speed (m/s), its relative error, and radius (m)."""
    return _HINT.pack(speed, error, radius)


def _text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise FrameError("the text in a frame is not UTF-8") from error
