"""Device's side of the serial protocol in Python, for simulated devices.

It behaves like the firmware, ``firmware/core/fc_device.c``.
"""

from __future__ import annotations

import secrets
import select
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from firstcontact.device import protocol
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.ports import PseudoTerminal
from firstcontact.device.protocol import FRAME_SAMPLES, FrameError, FrameType

#: Longest stuffed frame of a host, bytes. Longer ones are ignored.
LONGEST_HEARD = 256
#: Largest number of the device's own markers in the queue. More markers push out the oldest one.
MARKERS_WAITING = 16

#: Length of the buffer of simulated devices for a host that does not read, s of the host's time.
RING = 0.5
#: Approximate number of bytes of frames that a terminal's device prepares in advance.
WIRE_BYTES = 4096


@dataclass(slots=True)
class _Run:
    """Consecutive samples as bytes, with the numbers ``first`` to ``end`` (exclusive).

    ``overflow`` is the number of samples that the device has dropped since its start and before
    these samples.
    """

    first: int
    end: int
    overflow: int
    data: bytearray = field(default_factory=bytearray)


class Responder:
    """State machine of the device's side of the protocol.

    The caller passes on the host's bytes by :meth:`hear`, and sends what :meth:`frame` returns.
    ``room`` is the number of samples that the device can store. ``on_order`` obeys an order's text
    and returns the text of the answer.
    """

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
        self._width = descriptor.layout.width
        self._boot = boot
        self._on_order = on_order
        self._counter = 0
        self._most = room
        self._runs: deque[_Run] = deque()
        self._waiting = 0  # number of samples in the runs
        self._heard = bytearray()
        self._reply: tuple[FrameType, bytes] | None = None
        self._markers: deque[tuple[int, str]] = deque(maxlen=MARKERS_WAITING)

    @property
    def listens(self) -> bool:
        """True if the device reads the host's bytes; False while a reply waits to be sent."""
        return self._reply is None

    @property
    def room(self) -> int:
        return self._most - self._waiting if self.streaming else self._most

    def sample(self, data: NDArray[np.int16]) -> None:
        taken = min(len(data), self.room) if self.streaming else 0
        if taken:
            if not self._runs or self._runs[-1].end != self.next_sample:
                self._runs.append(_Run(self.next_sample, self.next_sample, self.overflow))
            self._runs[-1].data += np.ascontiguousarray(data[:taken], "<i2").tobytes()
            self._runs[-1].end += taken
            self._waiting += taken
        self.next_sample += len(data)
        if self.streaming:
            self.overflow += len(data) - taken

    def marker(self, sample: int, text: str) -> None:
        """Queue a marker of the device itself, to send after all samples before ``sample``."""
        if self.streaming:
            self._markers.append((sample, text))

    def hear(self, data: bytes) -> None:
        """Process bytes from the host. Bytes after a request wait until the reply is sent."""
        self._heard += data
        self._handle_frames()

    def frame(self) -> bytes:
        """Return the next frame to send, with its final zero byte; b"" if there is none."""
        stopping = self._reply is not None and self._reply[0] is FrameType.STOPPED
        if self._reply is not None and not stopping:
            return self._answer()
        if self._markers and not (self._runs and self._runs[0].first < self._markers[0][0]):
            sample, text = self._markers.popleft()
            return self._encode(FrameType.MARKER, protocol.marker_payload(sample, text))
        if self._runs:
            run = self._runs[0]
            n = min(FRAME_SAMPLES, run.end - run.first)
            if n == FRAME_SAMPLES or len(self._runs) > 1 or stopping or self.finished:
                return self._samples(run, n)
        return self._answer() if stopping else b""

    def _answer(self) -> bytes:
        assert self._reply is not None
        out = self._encode(*self._reply)
        self._reply = None
        self._handle_frames()
        return out

    def _samples(self, run: _Run, n: int) -> bytes:
        size = 2 * n * self._width
        data = np.frombuffer(bytes(run.data[:size]), "<i2").reshape(n, -1)
        payload = protocol.samples_payload(run.first, run.overflow, data)
        del run.data[:size]
        run.first += n
        if not run.data:
            self._runs.popleft()
        self._waiting -= n
        return self._encode(FrameType.SAMPLES, payload)

    def _encode(self, kind: FrameType, payload: bytes) -> bytes:
        out = protocol.encode(kind, self._counter, payload)
        self._counter += 1
        return out

    def _handle_frames(self) -> None:
        """Process received frames in order. Stop after the first frame that needs a reply."""
        while self._reply is None and 0 in self._heard:
            stuffed, _, self._heard = self._heard.partition(b"\0")
            if not 0 < len(stuffed) <= LONGEST_HEARD:
                continue
            try:
                frame = protocol.decode(bytes(stuffed))
            except FrameError:
                continue
            self.handle(frame.type, frame.payload)
        if 0 not in self._heard:
            # Keep enough bytes to detect that the frame is too long.
            del self._heard[LONGEST_HEARD + 1 :]

    def handle(self, kind: int, payload: bytes) -> None:
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


class TerminalDevice:
    """Base class of simulated devices on a pseudo terminal. A subclass makes the samples."""

    def __init__(self, terminal: PseudoTerminal) -> None:
        self._terminal = terminal
        self._boot = secrets.randbits(31)
        self._wire = b""  # prepared frames that the line has not taken
        self._responder: Responder

    def _restart(
        self, descriptor: Descriptor, room: int, on_order: Callable[[str], str] | None = None
    ) -> None:
        """Restart the simulated device with a new boot number. All counters start from 0.

        The parameters are those of :class:`Responder`.
        """
        self._boot += 1
        self._responder = Responder(descriptor, self._boot, room, on_order)

    def _send(self) -> None:
        """Send as many bytes of the prepared frames as the port accepts."""
        while self._terminal.plugged:
            while len(self._wire) < WIRE_BYTES and (frame := self._next_frame()):
                self._wire += frame
            sent = self._terminal.write(self._wire) if self._wire else 0
            self._wire = self._wire[sent:]
            if not sent:
                return

    def _next_frame(self) -> bytes:
        return self._responder.frame()

    def _wait(self, seconds: float, *inputs: int) -> list[int | PseudoTerminal]:
        """Wait until the host or an input has sent bytes, or the port accepts more bytes.

        Wait at most ``seconds`` s. ``inputs`` are file descriptors. Return the inputs that have
        bytes to read. The list also has the terminal if the host has sent bytes.
        """
        listening: list[int | PseudoTerminal] = [*inputs]
        if self._terminal.plugged and self._responder.listens:
            listening.append(self._terminal)
        full = [self._terminal] if self._wire else []
        return select.select(listening, full, [], seconds)[0]
