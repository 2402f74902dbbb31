"""Device side of the wire protocol. It takes samples and the host's bytes, and returns frames.

It has no I/O and no clock, and behaves like ``firmware/core/fc_device.c``. Samples wait in a ring
buffer until the line takes them. When the ring is full, samples are dropped and counted. The
protocol is in ``docs/protocol.md``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from firstcontact.device import _protocol as protocol
from firstcontact.device._descriptor import Descriptor
from firstcontact.device._protocol import FRAME_SAMPLES, FrameError, FrameType

#: Longest stuffed frame of a host, bytes. Longer ones are ignored.
LONGEST_HEARD = 256
#: Largest number of the device's own markers in the queue. More markers push out the oldest one.
MARKERS_WAITING = 16


class Responder:
    """State machine of the device's side of the protocol."""

    def __init__(
        self,
        descriptor: Descriptor,
        boot: int,
        room: int,
        on_order: Callable[[str], str] | None = None,
    ) -> None:
        self.next_sample = 0
        self.overflow = 0
        self.streaming = False
        self.finished = False
        self._descriptor = descriptor
        self._boot = boot
        self._on_order = on_order
        self._counter = 0
        self._ring = np.empty((room, descriptor.layout.width), np.int16)
        self._numbers = np.zeros(room, np.int64)
        self._overflows = np.zeros(room, np.int64)
        self._tail = 0
        self._used = 0
        self._heard = bytearray()
        self._reply: tuple[FrameType, bytes] | None = None
        self._markers: deque[tuple[int, str]] = deque(maxlen=MARKERS_WAITING)

    @property
    def listens(self) -> bool:
        """Return True if the device reads bytes from the host; False while a reply is due."""
        return self._reply is None

    @property
    def room(self) -> int:
        """Number of samples that still fit in the ring."""
        return len(self._ring) - self._used if self.streaming else len(self._ring)

    def sample(self, data: NDArray[np.int16]) -> None:
        """Add the next samples, shape (n, channels)."""
        n = len(data)
        if self.streaming:
            room = len(self._ring)
            taken = min(n, room - self._used)
            slots = (self._tail + self._used + np.arange(taken)) % room
            self._ring[slots] = data[:taken]
            self._numbers[slots] = self.next_sample + np.arange(taken)
            self._overflows[slots] = self.overflow
            self._used += taken
            self.overflow += n - taken
        self.next_sample += n

    def marker(self, sample: int, text: str) -> None:
        """Send a marker that the device made itself, after all samples before ``sample``."""
        if self.streaming:
            self._markers.append((sample, text))

    def hear(self, data: bytes) -> None:
        """Process bytes from the host. Bytes after a request wait for its reply."""
        self._heard += data
        self._obey()

    def frame(self) -> bytes:
        """Return the next frame to send, with its final zero; b"" if there is none."""
        stopping = self._reply is not None and self._reply[0] is FrameType.STOPPED
        if self._reply is not None and not stopping:
            return self._answer()
        if self._markers and not self._has_earlier_samples(self._markers[0][0]):
            sample, text = self._markers.popleft()
            return self._encode(FrameType.MARKER, protocol.marker_payload(sample, text))
        n = self._in_a_row()
        if n == FRAME_SAMPLES or 0 < n < self._used or (n and (stopping or self.finished)):
            return self._samples(n)
        return self._answer() if stopping else b""

    def _answer(self) -> bytes:
        assert self._reply is not None
        out = self._encode(*self._reply)
        self._reply = None
        self._obey()
        return out

    def _has_earlier_samples(self, sample: int) -> bool:
        """Return True if the ring holds samples before ``sample``."""
        return self._used > 0 and int(self._numbers[self._tail]) < sample

    def _in_a_row(self) -> int:
        """Return how many consecutive samples go into the next frame, at most five."""
        most = min(FRAME_SAMPLES, self._used)
        first = int(self._numbers[self._tail])
        room = len(self._ring)
        while most > 1 and int(self._numbers[(self._tail + most - 1) % room]) != first + most - 1:
            most -= 1
        return most

    def _samples(self, n: int) -> bytes:
        first, overflow = int(self._numbers[self._tail]), int(self._overflows[self._tail])
        data = self._ring.take(range(self._tail, self._tail + n), axis=0, mode="wrap")
        self._tail = (self._tail + n) % len(self._ring)
        self._used -= n
        return self._encode(FrameType.SAMPLES, protocol.samples_payload(first, overflow, data))

    def _encode(self, kind: FrameType, payload: bytes) -> bytes:
        out = protocol.encode(kind, self._counter, payload)
        self._counter += 1
        return out

    def _obey(self) -> None:
        """Process the host's frames up to the first one that needs a reply."""
        while self._reply is None and 0 in self._heard:
            stuffed, _, self._heard = self._heard.partition(b"\0")
            if not 0 < len(stuffed) <= LONGEST_HEARD:
                continue
            try:
                frame = protocol.decode(bytes(stuffed))
            except FrameError:
                continue
            self._do(frame.type, frame.payload)
        if 0 not in self._heard:
            # Keep enough bytes to detect that the frame is too long.
            del self._heard[LONGEST_HEARD + 1 :]

    def _do(self, kind: int, payload: bytes) -> None:
        match kind:
            case FrameType.HELLO if payload:
                self._reply = self._hello_reply(payload[0])
            case FrameType.START:
                self.streaming = True
            case FrameType.STOP:
                self.streaming = False
                self._markers.clear()
                stopped = protocol.stopped_payload(self.next_sample, self.overflow)
                self._reply = (FrameType.STOPPED, stopped)
            case FrameType.MARK if len(payload) <= protocol.MARKER_BYTES:
                self._reply = self._marker(payload.decode(errors="replace"))
            case FrameType.ORDER if self._on_order and len(payload) <= protocol.MARKER_BYTES:
                self._reply = self._marker(self._on_order(payload.decode(errors="replace")))
            case _:
                pass  # frames of a later version

    def _marker(self, text: str) -> tuple[FrameType, bytes]:
        return FrameType.MARKER, protocol.marker_payload(self.next_sample, text)

    def _hello_reply(self, version: int) -> tuple[FrameType, bytes]:
        if version == protocol.VERSION:
            text = self._descriptor.to_text()
            return FrameType.DESCRIPTOR, protocol.descriptor_payload(self._boot, text)
        reason = f"this device speaks version {protocol.VERSION} of the protocol, not {version}"
        return FrameType.REFUSED, bytes([protocol.VERSION]) + reason.encode()
