"""Minimal host at a serial port, to test a device."""

import time
from collections.abc import Callable
from typing import Self

import numpy as np
import serial
from numpy.typing import NDArray

from firstcontact.device import protocol
from firstcontact.device.protocol import Frame, FrameType
from prediction_payloads import SamplesFrame, read_samples

CHANNELS = 16
#: Longest wait for an answer, s.
PATIENCE = 60.0


class Host:
    """Host that sends frames and keeps all received frames in order."""

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
        """Read the bytes that have arrived, with a short wait for the first."""
        *complete, self._rest = (self._rest + self.port.read(65536)).split(b"\0")
        for stuffed in complete:
            try:
                self.frames.append(protocol.decode(stuffed))
            except protocol.FrameError:
                self.bad += 1

    def until(self, condition: Callable[[], object]) -> None:
        """Receive until the condition is true."""
        latest = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < latest, f"no answer; {len(self.frames)} frames until then"
            self.receive()

    def answer(self, kind: int) -> Frame:
        """Wait for the next frame of this kind and return it."""
        count = len(self.select_frames(kind))
        self.until(lambda: len(self.select_frames(kind)) > count)
        return self.select_frames(kind)[count]

    def hello(self) -> Frame:
        self.send(FrameType.HELLO, bytes([protocol.VERSION]))
        return self.answer(FrameType.DESCRIPTOR)

    def stop(self) -> tuple[int, int]:
        """Stop the device. Return the next sample's number and the overflow count."""
        self.send(FrameType.STOP)
        return protocol.read_stopped(self.answer(FrameType.STOPPED).payload)

    def mark(self, text: str = "") -> tuple[int, str]:
        self.send(FrameType.MARK, text.encode())
        return protocol.read_marker(self.answer(FrameType.MARKER).payload)

    def select_frames(self, kind: int) -> list[Frame]:
        return [f for f in self.frames if f.type == kind]

    def samples(self) -> list[SamplesFrame]:
        return [read_samples(f.payload, CHANNELS) for f in self.select_frames(FrameType.SAMPLES)]

    @property
    def received(self) -> int:
        return sum(len(s.data) for s in self.samples())

    def data(self) -> NDArray[np.int16]:
        """Return all received samples, shape (n, channels)."""
        return np.concatenate([s.data for s in self.samples()])

    def assert_all_frames(self) -> None:
        assert self.bad == 0
        assert [f.counter for f in self.frames] == list(range(len(self.frames)))

    def assert_all_samples(self, first: int = 0) -> None:
        self.assert_all_frames()
        for frame in self.samples():
            assert frame.first_sample == first
            assert frame.overflow == 0
            first += len(frame.data)


def assert_gaps_are_overflow(frames: list[SamplesFrame]) -> None:
    """Assert that each gap equals the number of samples that the device counted as dropped."""
    end, overflow = 0, 0
    for frame in frames:
        assert frame.first_sample - end == frame.overflow - overflow
        end, overflow = frame.first_sample + len(frame.data), frame.overflow
