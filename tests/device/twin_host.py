"""Host of the twin on its terminal, which reads only when a test asks it to."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block
from firstcontact.device.assembler import Assembler
from firstcontact.device.ports import SerialTransport
from firstcontact.device.protocol import VERSION, FrameType
from firstcontact.twin import TwinStream
from firstcontact.twin.sensor import DeviceFilter
from processes import PATIENCE


@cache
def expected(samples: int) -> NDArray[np.int16]:
    """Return what a twin with seed 4 must send, from its first sample on."""
    return DeviceFilter().update(TwinStream(seed=4).read(samples))


class Host:
    """Host that asks for the descriptor, and assembles what it reads."""

    def __init__(self, port: str) -> None:
        self._transport = SerialTransport(port)
        self.say = self._transport.send
        self.assembler = Assembler()
        self.blocks: list[Block] = []
        self.markers: list[tuple[int, str]] = []
        self.is_stopped = False
        self.say(FrameType.HELLO, bytes([VERSION]))
        self.listen(lambda: self.assembler.epoch >= 0)

    def close(self) -> None:
        self._transport.close()

    @property
    def received(self) -> int:
        return self.assembler.counts.samples

    def listen(self, enough: Callable[[], object]) -> None:
        waits = 0
        while not enough():
            data = self._transport.read()
            waits = 0 if data else waits + 1
            assert waits < PATIENCE / 0.05, "the twin has gone silent"
            assembled = self.assembler.feed(data)
            self.blocks += assembled.blocks
            self.markers += [(m.sample, m.text) for m in assembled.markers]
            self.is_stopped |= assembled.stopped

    def start(self, samples: int) -> None:
        """Start the samples and read this number of them."""
        self.say(FrameType.START)
        until = self.received + samples
        self.listen(lambda: self.received >= until)

    def stop(self) -> int:
        """Stop the samples. Assert that they are right and losses are counted. Return the end."""
        self.say(FrameType.STOP)
        self.listen(lambda: self.is_stopped)
        counts = self.assembler.counts
        right = expected(self.assembler.next_sample)
        for block in self.blocks:
            np.testing.assert_array_equal(block.data, right[block.first_sample : block.end])
        assert counts.lost_samples == counts.overflow_samples
        assert counts.lost_frames == counts.malformed_frames == self.assembler.decoder.bad == 0
        return self.assembler.next_sample


@contextmanager
def host(port: str) -> Iterator[Host]:
    connection = Host(port)
    try:
        yield connection
    finally:
        connection.close()
