"""Tests of the device side of the protocol, from the host's view."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from firstcontact.core import fingertip_layout
from firstcontact.device import Descriptor, FrameType, encode
from firstcontact.device import _protocol as protocol
from firstcontact.device._protocol import Frame
from firstcontact.device._responder import Responder

DESCRIPTOR = Descriptor(fingertip_layout(), "test", "sensor", "hand", "twin")
CHANNELS = 16


def numbered(first: int, n: int) -> NDArray[np.int16]:
    """Return samples with their own number in channel 0."""
    data = np.zeros((n, CHANNELS), np.int16)
    data[:, 0] = np.arange(first, first + n)
    return data


@dataclass
class Host:
    """Host that decodes the frames of a device."""

    device: Responder
    message_count: int = 0
    frames: list[Frame] = field(default_factory=list)

    def say(self, kind: int, payload: bytes = b"") -> None:
        self.device.hear(encode(kind, self.message_count, payload))
        self.message_count += 1

    def make(self, n: int) -> None:
        self.device.sample(numbered(self.device.next_sample, n))

    def listen(self) -> list[Frame]:
        """Return all frames available now."""
        new = []
        while wire := self.device.frame():
            assert wire.endswith(b"\0")
            new.append(protocol.decode(wire[:-1]))
        self.frames += new
        assert [f.counter for f in self.frames] == list(range(len(self.frames)))
        return new

    def numbers(self) -> list[int]:
        """Return the numbers of received samples, checked against their content."""
        out: list[int] = []
        for frame in self.frames:
            if frame.type == FrameType.SAMPLES:
                s = protocol.read_samples(frame.payload, CHANNELS)
                assert 1 <= len(s.data) <= 5
                assert list(s.data[:, 0]) == list(
                    range(s.first_sample, s.first_sample + len(s.data))
                )
                out += list(s.data[:, 0])
        return out


def device(room: int = 1000) -> Host:
    return Host(Responder(DESCRIPTOR, 7, room))


def test_hello_is_answered_with_the_descriptor() -> None:
    host = device()
    host.say(FrameType.HELLO, b"\1")
    (frame,) = host.listen()
    assert frame.type == FrameType.DESCRIPTOR
    version, boot, text = protocol.read_descriptor(frame.payload)
    assert (version, boot) == (protocol.VERSION, 7)
    assert Descriptor.from_text(text) == DESCRIPTOR


@given(st.lists(st.integers(0, 40), max_size=20))
def test_frames_have_five_samples_and_stop_flushes(blocks: list[int]) -> None:
    host = device()
    host.say(FrameType.START)
    for n in blocks:
        host.make(n)
        host.listen()
    total = sum(blocks)
    assert len(host.numbers()) == total - total % 5
    host.say(FrameType.STOP)
    host.make(33)
    host.listen()
    assert host.numbers() == list(range(total))
    assert host.frames[-1].type == FrameType.STOPPED
    assert protocol.read_stopped(host.frames[-1].payload) == (total, 0)
    host.make(50)
    assert host.listen() == []


@given(
    st.integers(1, 30),
    st.lists(st.tuples(st.integers(0, 25), st.integers(0, 4)), max_size=25),
)
def test_received_and_overflow_sum_to_all_samples(room: int, turns: list[tuple[int, int]]) -> None:
    host = device(room)
    host.say(FrameType.START)
    for produced, frame_count in turns:
        host.make(produced)
        for _ in range(frame_count):
            wire = host.device.frame()
            if wire:
                host.frames.append(protocol.decode(wire[:-1]))
    host.say(FrameType.STOP)
    host.listen()
    total = sum(produced for produced, _ in turns)
    numbers = host.numbers()
    assert numbers == sorted(set(numbers))
    assert protocol.read_stopped(host.frames[-1].payload) == (total, total - len(numbers))
    # What each frame tells is what is missing before it.
    count = 0
    for frame in host.frames:
        if frame.type == FrameType.SAMPLES:
            s = protocol.read_samples(frame.payload, CHANNELS)
            assert s.overflow == s.first_sample - count
            count += len(s.data)


def test_a_mark_is_echoed_with_the_number_of_the_next_sample() -> None:
    orders: list[str] = []
    host = Host(Responder(DESCRIPTOR, 1, 100, lambda text: orders.append(text) or "done"))
    host.make(42)
    host.say(FrameType.MARK, "Müller: apple".encode())
    (frame,) = host.listen()
    assert frame.type == FrameType.MARKER
    assert protocol.read_marker(frame.payload) == (42, "Müller: apple")
    host.say(FrameType.MARK, bytes(201))
    assert host.listen() == []
    assert orders == [], "a mark is no order"


def test_order_is_answered_with_its_result() -> None:
    orders: list[str] = []
    host = Host(Responder(DESCRIPTOR, 1, 100, lambda text: orders.append(text) or "done"))
    host.make(7)
    host.say(FrameType.ORDER, b"hand: release")
    (frame,) = host.listen()
    assert frame.type == FrameType.MARKER
    assert protocol.read_marker(frame.payload) == (7, "done")
    host.say(FrameType.ORDER, bytes(201))
    assert host.listen() == []
    assert orders == ["hand: release"]


def test_marker_of_the_device_follows_earlier_samples() -> None:
    host = device()
    host.say(FrameType.START)
    host.make(20)
    host.device.marker(10, "twin: apple 1")
    kinds = [f.type for f in host.listen()]
    assert kinds == [FrameType.SAMPLES] * 2 + [FrameType.MARKER] + [FrameType.SAMPLES] * 2


def test_consecutive_requests_are_answered_in_order() -> None:
    host = device()
    host.make(3)
    breath = [(FrameType.HELLO, b"\1"), (FrameType.MARK, b"a"), (FrameType.START, b"")]
    host.device.hear(b"".join(encode(kind, k, p) for k, (kind, p) in enumerate(breath)))
    assert not host.device.listens
    host.listen()
    assert host.device.listens
    host.make(5)
    host.listen()
    kinds = [f.type for f in host.frames]
    assert kinds == [FrameType.DESCRIPTOR, FrameType.MARKER, FrameType.SAMPLES]


@given(st.binary(max_size=600), st.integers(1, 40))
def test_noise_between_requests_is_ignored(noise: bytes, piece: int) -> None:
    host = device()
    wire = noise + b"\0" + encode(FrameType.HELLO, 0, b"\1")
    for k in range(0, len(wire), piece):
        host.device.hear(wire[k : k + piece])
    assert [f.type for f in host.listen()] == [FrameType.DESCRIPTOR]
