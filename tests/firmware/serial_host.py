"""A host at a serial port, as plain as can be: what is tested here is the device."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Self

import numpy as np
import serial
from numpy.typing import NDArray

from firstcontact.device import FrameType
from firstcontact.device import _protocol as protocol
from firstcontact.device._protocol import Frame

CHANNELS = 16
#: No answer after this long means that none comes, s.
PATIENCE = 60.0


class Host:
    """Sends frames and keeps all that come, in order."""

    def __init__(self, path: str) -> None:
        self.port = serial.Serial(path, timeout=0.05)
        self.frames: list[Frame] = []
        self.bad = 0
        self._rest = b""
        self._sent = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.port.close()

    def send(self, kind: int, payload: bytes = b"") -> None:
        self.port.write(protocol.encode(kind, self._sent, payload))
        self._sent += 1

    def receive(self) -> None:
        """Take what has come, waiting a moment for a first byte."""
        *whole, self._rest = (self._rest + self.port.read(65536)).split(b"\0")
        for stuffed in whole:
            try:
                self.frames.append(protocol.decode(stuffed))
            except protocol.FrameError:
                self.bad += 1

    def until(self, done: Callable[[], object]) -> None:
        """Receive until ``done`` says something true."""
        latest = time.monotonic() + PATIENCE
        while not done():
            assert time.monotonic() < latest, f"no answer; {len(self.frames)} frames until then"
            self.receive()

    def answer(self, kind: int) -> Frame:
        """The next frame of a kind that was not there yet."""
        known = len(self.of(kind))
        self.until(lambda: len(self.of(kind)) > known)
        return self.of(kind)[known]

    def hello(self) -> Frame:
        self.send(FrameType.HELLO, bytes([protocol.VERSION]))
        return self.answer(FrameType.DESCRIPTOR)

    def stop(self) -> tuple[int, int]:
        """Next sample's number and overflow, of the ``stopped`` frame."""
        self.send(FrameType.STOP)
        return protocol.read_stopped(self.answer(FrameType.STOPPED).payload)

    def mark(self, text: str = "") -> tuple[int, str]:
        self.send(FrameType.MARK, text.encode())
        return protocol.read_marker(self.answer(FrameType.MARKER).payload)

    def of(self, kind: int) -> list[Frame]:
        return [f for f in self.frames if f.type == kind]

    def samples(self) -> list[protocol.SamplesFrame]:
        return [protocol.read_samples(f.payload, CHANNELS) for f in self.of(FrameType.SAMPLES)]

    @property
    def received(self) -> int:
        return sum(len(s.data) for s in self.samples())

    def data(self) -> NDArray[np.int16]:
        """All samples received, shape (n, channels)."""
        return np.concatenate([s.data for s in self.samples()])

    def assert_every_frame_arrived(self) -> None:
        assert self.bad == 0
        assert [f.counter for f in self.frames] == list(range(len(self.frames)))

    def assert_every_sample_arrived(self, first: int = 0) -> None:
        self.assert_every_frame_arrived()
        for frame in self.samples():
            assert frame.first_sample == first
            assert frame.overflow == 0
            first += len(frame.data)


def assert_gaps_are_overflow(frames: list[protocol.SamplesFrame]) -> None:
    """What is missing before a frame is what the device says it dropped since the last one."""
    end, overflow = 0, 0
    for frame in frames:
        assert frame.first_sample - end == frame.overflow - overflow
        end, overflow = frame.first_sample + len(frame.data), frame.overflow
