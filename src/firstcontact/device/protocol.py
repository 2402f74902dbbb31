"""Encoder and decoder of the serial protocol's frames (``docs/protocol.md``, version 1)."""

from __future__ import annotations

import struct
import zlib
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.installation import load_compiled

VERSION = 1
#: Largest number of samples in a frame: 1 ms at 4936 Hz.
FRAME_SAMPLES = 5
#: Longest text of a marker or an order, bytes.
MARKER_BYTES = 200
#: Length limit of a stuffed frame, bytes. A descriptor of 100 channels fits.
LONGEST = 16_384
_MASK = 0xFFFFFFFF
_HEAD = struct.Struct("<BI")
_CRC = struct.Struct("<I")
_SAMPLES = struct.Struct("<IIB")
_DESCRIPTOR = struct.Struct("<BI")
_STOPPED = struct.Struct("<II")
_MARKER = struct.Struct("<I")
_LATE = struct.Struct("<II")
_HINT = struct.Struct("<fff")


class FrameType(IntEnum):
    """Type of a frame, given by its first byte."""

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
    type: int
    counter: int
    payload: bytes


class NextSamples(NamedTuple):
    """Fields that the next frame of samples must have if nothing was lost, modulo 2^32.

    ``width`` is the number of columns of a sample, ``counter`` the frame's number, and ``overflow``
    the number of samples that the device has dropped.
    """

    width: int
    counter: int
    first_sample: int
    overflow: int


def stuff(data: bytes) -> bytes:
    """Encode bytes with COBS, so that they contain no zero. Append the frame's final zero later."""
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
    body = _HEAD.pack(kind, counter & _MASK) + payload
    return stuff(body + _CRC.pack(zlib.crc32(body))) + b"\0"


def decode(stuffed: bytes) -> Frame:
    body = unstuff(stuffed)
    if len(body) < _HEAD.size + _CRC.size:
        raise FrameError("a frame is too short")
    if _CRC.unpack_from(body, len(body) - _CRC.size)[0] != zlib.crc32(body[: -_CRC.size]):
        raise FrameError("a frame's checksum (CRC) does not match its content")
    kind, counter = _HEAD.unpack_from(body)
    return Frame(kind, counter, body[_HEAD.size : -_CRC.size])


def unpack(form: struct.Struct, payload: bytes, kind: FrameType) -> tuple[Any, ...]:
    """Return the numbers in a frame's payload. Raise FrameError if its length is wrong."""
    if len(payload) != form.size:
        raise FrameError(f"a frame of type {kind.name} has the wrong length")
    return form.unpack(payload)


def _split(form: struct.Struct, payload: bytes, kind: FrameType) -> tuple[tuple[Any, ...], bytes]:
    """Return the numbers at the beginning of a frame's payload, and the bytes after them.

    ``form`` describes these numbers. Raises FrameError if the payload is too short.
    """
    return unpack(form, payload[: form.size], kind), payload[form.size :]


def samples_payload(first_sample: int, overflow: int, data: NDArray[np.int16]) -> bytes:
    """Return the payload of a frame with 1 to 5 samples, ``data``, shape (samples, channels).

    ``first_sample`` is the number of the first one, and ``overflow`` the number of samples that the
    device has dropped.
    """
    head = _SAMPLES.pack(first_sample & _MASK, overflow & _MASK, len(data))
    return head + np.ascontiguousarray(data, dtype="<i2").tobytes()


def samples_head(payload: bytes, channels: int) -> tuple[int, int, int, bytes]:
    """Split a payload of :func:`samples_payload`. Raise FrameError if its length is wrong.

    Return the first sample's number, the number of dropped samples, the number of samples in the
    frame, and their bytes.
    """
    (first, overflow, n), data = _split(_SAMPLES, payload, FrameType.SAMPLES)
    if n < 1 or len(data) != 2 * n * channels:
        raise FrameError(
            f"a frame of type SAMPLES does not hold the {n} samples of {channels} channels that "
            "it declares"
        )
    return first, overflow, n, data


def descriptor_payload(boot: int, text: str, version: int = VERSION) -> bytes:
    return _DESCRIPTOR.pack(version, boot) + text.encode()


def read_descriptor(payload: bytes) -> tuple[int, int, str]:
    (version, boot), text = _split(_DESCRIPTOR, payload, FrameType.DESCRIPTOR)
    return version, boot, _text(text)


def marker_payload(sample: int, text: str) -> bytes:
    return _MARKER.pack(sample & _MASK) + marker_text(text)


def marker_text(text: str) -> bytes:
    """Return a marker's text as UTF-8, cut after a whole character to fit a frame."""
    return text.encode()[:MARKER_BYTES].decode(errors="ignore").encode()


def read_marker(payload: bytes) -> tuple[int, str]:
    (sample,), text = _split(_MARKER, payload, FrameType.MARKER)
    return sample, _text(text)


def stopped_payload(next_sample: int, overflow: int) -> bytes:
    return _STOPPED.pack(next_sample & _MASK, overflow & _MASK)


def read_stopped(payload: bytes) -> tuple[int, int]:
    next_sample, overflow = unpack(_STOPPED, payload, FrameType.STOPPED)
    return next_sample, overflow


def read_late(payload: bytes) -> tuple[int, int]:
    skipped, unheard = unpack(_LATE, payload, FrameType.LATE)
    return skipped, unheard


def hint_payload(speed: float, error: float, radius: float) -> bytes:
    """Return the payload of a hint: closing speed (m/s), its relative error, and radius (m)."""
    return _HINT.pack(speed, error, radius)


def _text(data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        raise FrameError("the text in a frame is not UTF-8") from error


class Decoder:
    """Decoder that splits a stream of bytes into frames.

    ``bad`` counts damaged pieces, not lost frames: a wrong bit can split a frame into two pieces.
    The first piece of the stream may be the end of a frame, and is not counted.
    """

    def __init__(self) -> None:
        self.bad = 0  #: Number of damaged pieces so far.
        self.restart()

    def restart(self) -> None:
        self._rest = b""
        self._first = True
        self._too_long = False

    def feed_samples(self, data: bytes, expected: NextSamples) -> tuple[int, bytes]:
        """Add the next bytes. Decode only the frames of samples that come first and lack none.

        Return the number of these frames, and the bytes of their samples. Call :meth:`feed` for the
        rest. ``expected`` describes the first frame.
        """
        self._rest += data
        if self._too_long:
            return 0, b""
        frames: int
        samples: bytes
        used, frames, samples = load_compiled("firstcontact.device._compiled").decode_samples(
            self._rest, *expected
        )
        if used:
            self._rest = self._rest[used:]
            self._first = False
        return frames, samples

    def feed(self, data: bytes) -> list[Frame]:
        """Process the next bytes. Return the frames that they complete, in order."""
        *pieces, self._rest = (self._rest + data).split(b"\0")
        frames = []
        for piece in pieces:
            if piece or self._too_long:
                try:
                    if self._too_long:
                        raise FrameError("a frame is too long")
                    frames.append(decode(piece))
                except FrameError:
                    self.bad += not self._first
            self._first = self._too_long = False
        if len(self._rest) > LONGEST:
            self._rest = b""
            self._too_long = True
        return frames
