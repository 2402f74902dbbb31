"""Python interface of the C core: its functions with their types, by ctypes."""

from __future__ import annotations

import ctypes as c
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

TAXELS = 6
_BYTES = c.c_char_p


class _Frame(c.Structure):
    _fields_ = [
        ("type", c.c_uint8),
        ("counter", c.c_uint32),
        ("payload", c.c_void_p),
        ("n", c.c_size_t),
    ]


class _Estimate(c.Structure):
    _fields_ = [
        ("contact", c.c_uint32),
        ("known", c.c_uint32),
        ("samples", c.c_uint16),
        ("finger", c.c_uint8),
        ("flags", c.c_uint8),
        ("value", c.c_float),
        ("low", c.c_float),
        ("high", c.c_float),
        ("took", c.c_uint32),
    ]


class _Pace(c.Structure):
    _fields_ = [(name, c.c_uint32) for name in ("whole", "rest", "rate", "sum")]


class _Smooth(c.Structure):
    _fields_ = [("y", c.c_int32)]


class _Means(c.Structure):
    _fields_ = [
        ("reading", c.c_uint16 * 8 * TAXELS),
        ("sum", c.c_uint16 * TAXELS),
        ("oldest", c.c_uint8),
        ("read", c.c_bool * TAXELS),
    ]


class _Scan(c.Structure):
    _fields_ = [("taxel", c.c_uint8)]


class Core:
    """Shared library of the core. Each method calls it."""

    def __init__(self, path: Path) -> None:
        lib = c.CDLL(str(path))
        lib.fc_cobs_stuff.restype = c.c_size_t
        lib.fc_cobs_stuff.argtypes = [_BYTES, c.c_size_t, c.c_char_p]
        lib.fc_cobs_unstuff.restype = c.c_ssize_t
        lib.fc_cobs_unstuff.argtypes = [_BYTES, c.c_size_t, c.c_char_p]
        lib.fc_crc32.restype = c.c_uint32
        lib.fc_crc32.argtypes = [_BYTES, c.c_size_t]
        lib.fc_frame_encode.restype = c.c_size_t
        lib.fc_frame_encode.argtypes = [c.c_uint8, c.c_uint32, c.c_char_p, c.c_size_t, c.c_char_p]
        lib.fc_frame_decode.argtypes = [c.c_char_p, c.c_size_t, c.POINTER(_Frame)]
        lib.fc_put_descriptor.restype = c.c_size_t
        lib.fc_put_descriptor.argtypes = [c.c_char_p, c.c_uint32, _BYTES, c.c_size_t]
        lib.fc_put_samples_head.restype = c.c_size_t
        lib.fc_put_samples_head.argtypes = [c.c_char_p, c.c_uint32, c.c_uint32, c.c_uint8]
        lib.fc_put_marker.restype = c.c_size_t
        lib.fc_put_marker.argtypes = [c.c_char_p, c.c_uint32, _BYTES, c.c_size_t]
        lib.fc_put_stopped.restype = c.c_size_t
        lib.fc_put_stopped.argtypes = [c.c_char_p, c.c_uint32, c.c_uint32]
        lib.fc_put_refused.restype = c.c_size_t
        lib.fc_put_refused.argtypes = [c.c_char_p, _BYTES]
        lib.fc_put_contact.restype = c.c_size_t
        lib.fc_put_contact.argtypes = [c.c_char_p, c.c_uint32, c.c_uint32, c.c_uint8, c.c_bool]
        lib.fc_put_estimate.restype = c.c_size_t
        lib.fc_put_estimate.argtypes = [c.c_char_p, c.POINTER(_Estimate)]
        lib.fc_put_late.restype = c.c_size_t
        lib.fc_put_late.argtypes = [c.c_char_p, c.c_uint32, c.c_uint32]
        lib.fc_pace_init.argtypes = [c.POINTER(_Pace), c.c_uint32, c.c_uint32]
        lib.fc_pace_next.restype = c.c_uint32
        lib.fc_pace_next.argtypes = [c.POINTER(_Pace)]
        lib.fc_smooth_init.argtypes = [c.POINTER(_Smooth)]
        lib.fc_smooth_step.restype = c.c_int16
        lib.fc_smooth_step.argtypes = [c.POINTER(_Smooth), c.c_uint16]
        lib.fc_means_init.argtypes = [c.POINTER(_Means)]
        lib.fc_means_step.argtypes = [
            c.POINTER(_Means),
            c.c_uint8,
            c.c_uint16,
            c.POINTER(c.c_int16),
        ]
        for name in ("init", "next", "row", "column"):
            getattr(lib, f"fc_scan_{name}").argtypes = [c.POINTER(_Scan)]
        lib.fc_scan_row.restype = lib.fc_scan_column.restype = c.c_uint8
        self._lib = lib

    def stuff(self, data: bytes) -> bytes:
        out = c.create_string_buffer(len(data) + len(data) // 254 + 1)
        n = self._lib.fc_cobs_stuff(data, len(data), out)
        return out.raw[:n]

    def unstuff(self, data: bytes) -> bytes | None:
        """Undo the stuffing. Return None if the core refuses the bytes."""
        out = c.create_string_buffer(len(data) + 1)
        n = self._lib.fc_cobs_unstuff(data, len(data), out)
        return None if n < 0 else out.raw[:n]

    def crc32(self, data: bytes) -> int:
        return int(self._lib.fc_crc32(data, len(data)))

    def encode(self, kind: int, counter: int, payload: bytes) -> bytes:
        body = c.create_string_buffer(b"\0" * 5 + payload, 5 + len(payload) + 4)
        wire = c.create_string_buffer(2 * len(body) + 3)
        n = self._lib.fc_frame_encode(kind, counter, body, len(payload), wire)
        return wire.raw[:n]

    def decode(self, stuffed: bytes) -> tuple[int, int, bytes] | None:
        """Return type, counter and payload; None if the core refuses the frame."""
        wire = c.create_string_buffer(stuffed, len(stuffed) + 1)
        frame = _Frame()
        if self._lib.fc_frame_decode(wire, len(stuffed), c.byref(frame)) != 0:
            return None
        return frame.type, frame.counter, c.string_at(frame.payload, frame.n)

    def descriptor_payload(self, boot: int, text: bytes) -> bytes:
        out = c.create_string_buffer(5 + len(text))
        n = self._lib.fc_put_descriptor(out, boot, text, len(text))
        return out.raw[:n]

    def samples_head(self, first: int, overflow: int, n: int) -> bytes:
        out = c.create_string_buffer(9)
        n = self._lib.fc_put_samples_head(out, first, overflow, n)
        return out.raw[:n]

    def marker_payload(self, sample: int, text: bytes) -> bytes:
        out = c.create_string_buffer(4 + len(text))
        n = self._lib.fc_put_marker(out, sample, text, len(text))
        return out.raw[:n]

    def stopped_payload(self, next_sample: int, overflow: int) -> bytes:
        out = c.create_string_buffer(8)
        n = self._lib.fc_put_stopped(out, next_sample, overflow)
        return out.raw[:n]

    def refused_payload(self, reason: bytes) -> bytes:
        out = c.create_string_buffer(1 + len(reason))
        n = self._lib.fc_put_refused(out, reason)
        return out.raw[:n]

    def contact_payload(self, sample: int, decided: int, finger: int, first: bool) -> bytes:
        out = c.create_string_buffer(10)
        n = self._lib.fc_put_contact(out, sample, decided, finger, first)
        return out.raw[:n]

    def estimate_payload(self, *fields: float) -> bytes:
        """Return the payload of an estimate frame. The fields are in the frame's order."""
        out = c.create_string_buffer(28)
        n = self._lib.fc_put_estimate(out, c.byref(_Estimate(*fields)))
        return out.raw[:n]

    def late_payload(self, skipped: int, unheard: int) -> bytes:
        out = c.create_string_buffer(8)
        n = self._lib.fc_put_late(out, skipped, unheard)
        return out.raw[:n]

    def periods(self, clock: int, rate: int, n: int) -> list[int]:
        """Return the first n periods of a timer, ticks."""
        pace = _Pace()
        self._lib.fc_pace_init(c.byref(pace), clock, rate)
        return [self._lib.fc_pace_next(c.byref(pace)) for _ in range(n)]

    def taxels(self, n: int) -> list[tuple[int, int]]:
        """Return row and column of the taxel that each of the first n scans reads."""
        scan, out = _Scan(), []
        self._lib.fc_scan_init(c.byref(scan))
        for _ in range(n):
            out.append((self._lib.fc_scan_row(c.byref(scan)), self._lib.fc_scan_column(scan)))
            self._lib.fc_scan_next(c.byref(scan))
        return out

    def filtered(self, scans: NDArray[np.uint16]) -> NDArray[np.int16]:
        """Return the samples, shape (n, 16), that the filters make of raw scans, shape (n, 6)."""
        smooth, means = [_Smooth(), _Smooth()], [_Means(), _Means()]
        for f in range(2):
            self._lib.fc_smooth_init(smooth[f])
            self._lib.fc_means_init(means[f])
        out = np.empty((len(scans), 4 + 2 * TAXELS), np.int16)
        six = (c.c_int16 * TAXELS)()
        for i, scan in enumerate(scans):
            for f in range(2):
                out[i, f] = self._lib.fc_smooth_step(smooth[f], int(scan[f]))
                self._lib.fc_means_step(means[f], i % TAXELS, int(scan[2 + f]), six)
                out[i, 2 + TAXELS * f : 2 + TAXELS * (f + 1)] = six[:]
                out[i, 2 + 2 * TAXELS + f] = scan[4 + f]
        return out
