"""Python interface of the C core: its functions with their types, by ctypes."""

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


_SIZE, _U32, _U8 = c.c_size_t, c.c_uint32, c.c_uint8
#: Result and arguments of each function. Those named "put_" write a payload into a buffer.
_FUNCTIONS = {
    "cobs_stuff": (_SIZE, _BYTES, _SIZE, _BYTES),
    "cobs_unstuff": (c.c_ssize_t, _BYTES, _SIZE, _BYTES),
    "crc32": (_U32, _BYTES, _SIZE),
    "frame_encode": (_SIZE, _U8, _U32, _BYTES, _SIZE, _BYTES),
    "frame_decode": (c.c_int, _BYTES, _SIZE, c.POINTER(_Frame)),
    "put_descriptor": (_SIZE, _BYTES, _U32, _BYTES, _SIZE),
    "put_samples_head": (_SIZE, _BYTES, _U32, _U32, _U8),
    "put_marker": (_SIZE, _BYTES, _U32, _BYTES, _SIZE),
    "put_stopped": (_SIZE, _BYTES, _U32, _U32),
    "put_refused": (_SIZE, _BYTES, _BYTES),
    "put_contact": (_SIZE, _BYTES, _U32, _U32, _U8, c.c_bool),
    "put_estimate": (_SIZE, _BYTES, c.POINTER(_Estimate)),
    "put_late": (_SIZE, _BYTES, _U32, _U32),
    "pace_init": (None, c.POINTER(_Pace), _U32, _U32),
    "pace_next": (_U32, c.POINTER(_Pace)),
    "smooth_init": (None, c.POINTER(_Smooth)),
    "smooth_step": (c.c_int16, c.POINTER(_Smooth), c.c_uint16),
    "means_init": (None, c.POINTER(_Means)),
    "means_step": (None, c.POINTER(_Means), _U8, c.c_uint16, c.POINTER(c.c_int16)),
    "scan_init": (None, c.POINTER(_Scan)),
    "scan_next": (None, c.POINTER(_Scan)),
    "scan_row": (_U8, c.POINTER(_Scan)),
    "scan_column": (_U8, c.POINTER(_Scan)),
}


class Core:
    """Shared library of the core. Each method calls it."""

    def __init__(self, path: Path) -> None:
        self._lib = c.CDLL(str(path))
        for name, (result, *arguments) in _FUNCTIONS.items():
            function = getattr(self._lib, f"fc_{name}")
            function.restype, function.argtypes = result, arguments

    def _put(self, name: str, *arguments: object) -> bytes:
        """Return the payload that a function of the core writes."""
        out = c.create_string_buffer(1024)
        n = getattr(self._lib, f"fc_put_{name}")(out, *arguments)
        return out.raw[:n]

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
        return self._put("descriptor", boot, text, len(text))

    def samples_head(self, first: int, overflow: int, n: int) -> bytes:
        return self._put("samples_head", first, overflow, n)

    def marker_payload(self, sample: int, text: bytes) -> bytes:
        return self._put("marker", sample, text, len(text))

    def stopped_payload(self, next_sample: int, overflow: int) -> bytes:
        return self._put("stopped", next_sample, overflow)

    def refused_payload(self, reason: bytes) -> bytes:
        return self._put("refused", reason)

    def contact_payload(self, sample: int, decided: int, finger: int, first: bool) -> bytes:
        return self._put("contact", sample, decided, finger, first)

    def estimate_payload(self, *fields: float) -> bytes:
        """Return the payload of an estimate frame. The fields are in the frame's order."""
        return self._put("estimate", c.byref(_Estimate(*fields)))

    def late_payload(self, skipped: int, unheard: int) -> bytes:
        return self._put("late", skipped, unheard)

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
