"""Tests of the device side of the protocol, from the host's view."""

from dataclasses import dataclass, field

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered import CHANNELS, DESCRIPTOR, check, numbered

from firstcontact.core import Block
from firstcontact.device import Descriptor, protocol
from firstcontact.device.protocol import Frame, FrameType, encode
from firstcontact.device.responder import Responder
from prediction_payloads import SamplesFrame, read_samples


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

    def samples(self) -> list[SamplesFrame]:
        """Return the received frames of samples, checked against the numbers in the samples."""
        frames = [f.payload for f in self.frames if f.type == FrameType.SAMPLES]
        samples = [read_samples(payload, CHANNELS) for payload in frames]
        check(Block(s.data, s.first_sample) for s in samples)
        assert all(1 <= len(s.data) <= 5 for s in samples)
        return samples

    def numbers(self) -> list[int]:
        """Return the numbers of the received samples."""
        return [s.first_sample + k for s in self.samples() for k in range(len(s.data))]


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


@given(st.integers(1, 30), st.lists(st.tuples(st.integers(0, 25), st.integers(0, 4)), max_size=25))
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
    # The overflow in a frame is the number of samples that are missing before it.
    count = 0
    for s in host.samples():
        assert s.overflow == s.first_sample - count
        count += len(s.data)


@pytest.mark.parametrize(
    ("kind", "text", "echo"),
    [
        (FrameType.MARK, "Müller: apple", "Müller: apple"),
        (FrameType.MARK, "hand: release", "hand: release"),
        (FrameType.ORDER, "hand: release", "done"),
    ],
)
def test_marks_are_echoed_and_orders_are_answered(kind: FrameType, text: str, echo: str) -> None:
    orders: list[str] = []
    host = Host(Responder(DESCRIPTOR, 1, 100, lambda order: orders.append(order) or "done"))
    host.make(42)
    host.say(kind, text.encode())
    (frame,) = host.listen()
    assert frame.type == FrameType.MARKER
    assert protocol.read_marker(frame.payload) == (42, echo)
    host.say(kind, bytes(201))  # too long
    assert host.listen() == []
    assert orders == ([text] if kind == FrameType.ORDER else []), "a mark is no order"
