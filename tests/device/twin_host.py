"""Host of the twin on its terminal. It stores and checks all frames."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np
from numpy.typing import NDArray

from firstcontact.device import protocol
from firstcontact.device.protocol import Frame, FrameError, FrameType, SamplesFrame, encode
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter

#: A twin that says nothing for so long is dead, s.
DEAD = 60.0


@cache
def expected(samples: int) -> NDArray[np.int16]:
    """Return what a twin with seed 4 must send, from its first sample on."""
    return DeviceFilter().update(TwinStream(seed=4).read(samples))


class Host:
    """Host that reads and writes the bytes of the terminal directly."""

    def __init__(self, port: str) -> None:
        # As a plain file: it must be raw without a host that makes it so.
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
        self.said = 0
        self.rest = b""
        self.torn = False  # whether frames may be cut off
        self.samples: list[SamplesFrame] = []
        self.markers: list[tuple[int, str]] = []
        self.counters: list[int] = []
        self.longest_pause = 0.0  # between two reads that returned something, s
        self._heard = time.monotonic()

    def close(self) -> None:
        os.close(self.fd)

    def say(self, kind: int, payload: bytes = b"") -> None:
        os.write(self.fd, encode(kind, self.said, payload))
        self.said += 1

    def hear(self) -> list[Frame]:
        """Return the next bytes, at least one."""
        ready, _, _ = select.select([self.fd], [], [], DEAD)
        assert ready, "the twin has gone silent"
        previous, self._heard = self._heard, time.monotonic()
        self.longest_pause = max(self.longest_pause, self._heard - previous)
        *stuffed, self.rest = (self.rest + os.read(self.fd, 65_536)).split(b"\0")
        frames = []
        for one in stuffed:
            if not one:
                continue
            try:
                frames.append(protocol.decode(one))
            except FrameError:
                assert self.torn
        for frame in frames:
            self.counters.append(frame.counter)
            if frame.type == FrameType.SAMPLES:
                self.samples.append(protocol.read_samples(frame.payload, 16))
            elif frame.type == FrameType.MARKER:
                self.markers.append(protocol.read_marker(frame.payload))
        return frames

    def until(self, kind: FrameType) -> Frame:
        """Read until a frame of this kind comes."""
        while True:
            for frame in self.hear():
                if frame.type == kind:
                    return frame

    def listen(self, enough: Callable[[], bool]) -> None:
        while not enough():
            self.hear()

    def boot(self) -> int:
        self.say(FrameType.HELLO, bytes([protocol.VERSION]))
        return protocol.read_descriptor(self.until(FrameType.DESCRIPTOR).payload)[1]

    def start(self, samples: int) -> None:
        """Start the samples and read this number of them."""
        self.say(FrameType.START)
        self.listen(lambda: self.received >= samples)

    def stop(self) -> tuple[int, int]:
        """Stop the samples. Return the next sample's number and the overflow."""
        self.say(FrameType.STOP)
        return protocol.read_stopped(self.until(FrameType.STOPPED).payload)

    @property
    def received(self) -> int:
        return sum(len(s.data) for s in self.samples)

    @property
    def first(self) -> int:
        return self.samples[0].first_sample

    def check(self, stopped: tuple[int, int], right: NDArray[np.int16] | None = None) -> None:
        """Assert that all frames arrived, all samples are right, and losses are counted."""
        assert self.counters == list(range(self.counters[0], self.counters[0] + len(self.counters)))
        right = expected(stopped[0]) if right is None else right
        lost_count = 0
        number = self.first
        for s in self.samples:
            lost_count += s.first_sample - number
            assert s.overflow == lost_count
            number = s.first_sample + len(s.data)
            assert (s.data == right[s.first_sample : number]).all()
        assert self.received + stopped[1] == stopped[0] - self.first
        assert stopped[1] >= lost_count


@contextmanager
def host(port: str) -> Iterator[Host]:
    connection = Host(port)
    try:
        yield connection
    finally:
        connection.close()
