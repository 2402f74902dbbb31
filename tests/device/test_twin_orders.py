"""Tests of orders to the twin's hand, and of the texts between host and twin."""

import select
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from twin_host import host

from firstcontact.core import Command
from firstcontact.device.protocol import FrameType
from firstcontact.device.twin_process import TwinOptions
from firstcontact.device.twin_source import TwinDevice, TwinSource
from firstcontact.device.twin_words import order_text, parse_held_object, peak_text, read_order
from firstcontact.twin import TwinStream

#: Multiple of real time at which orders still arrive within a closing.
SPEED = 4


@pytest.fixture
def twin() -> Iterator[TwinDevice]:
    with TwinDevice(TwinOptions(seed=4, speed=20)) as device:
        yield device


def read_past(stream: TwinStream, sample: int) -> None:
    """Simulate the stream beyond a sample."""
    while stream.sample <= sample:
        stream.read(1000)


INVALID = (
    *("hand:", "hand: 1", "hand: 1 2 3", "hand: nan 1", "hand: 1 inf", "hand: halt"),
    *("hand:\0", "?"),
)


def test_each_invalid_order_is_answered_and_changes_nothing(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.start(1)
        for count, text in enumerate(INVALID, 1):
            h.say(FrameType.ORDER, text.encode())
            h.listen(
                lambda n=count: sum("twin: hand order" in content for _, content in h.markers) == n
            )
        h.stop()


def test_marks_are_not_orders() -> None:
    """A program or viewer that sets markers cannot move the hand."""
    with (
        TwinDevice(TwinOptions(seed=4, speed=SPEED, objects=["block 10", "apple 1"])) as device,
        host(device.port) as h,
    ):
        h.start(1)
        texts = ("object: block 10", "hand: release", "hand: 0.0 0.0", "twin: told hand: 0.0 0.0")

        def hand() -> list[tuple[int, str]]:
            return [(at, content) for at, content in h.markers if content not in texts]

        while sum("peak" in content for _, content in hand()) < 3:
            count = len(h.markers)
            h.listen(lambda count=count: len(h.markers) > count)
            if "peak" not in h.markers[-1][1] and h.markers[-1][1] not in texts:
                for text in texts:  # as a closing begins
                    h.say(FrameType.MARK, text.encode())
        assert {content for _, content in h.markers} >= set(texts)
        # The hand does what it would have done unasked.
        stream = TwinStream("paper-rig", ["block 10", "apple 1"], seed=4)
        read_past(stream, h.markers[-1][0])
        alone = [(p.start, f"twin: {p.label.object}") for p in stream.pinches]
        alone += [(p.end, peak_text(p.peak)) for p in stream.pinches if p.end and p.peak]
        assert set(hand()) <= set(alone)


def test_accelerated_twin_stays_close_to_its_reader() -> None:
    """If the twin ran ahead of a slow reader, a requested object would come late."""
    with TwinSource(TwinOptions(seed=4, speed=50)) as source:
        count = sum(len(a.block.data) for a in source.read(60.0))
        select.select([], [], [], 1.0)  # nobody reads: 50 s of the twin's time
        assert source.health.samples - count < 4936
        while count < 4 * 4936:
            count += sum(len(a.block.data) for a in source.read(60.0))
        assert source.health.lost_samples == 0
        source.order("object: block 10")
        objects: list[str | None] = []
        while "block 10" not in objects:
            assert count < 60 * 4936, objects
            arrivals = source.read(60.0)
            count += sum(len(a.block.data) for a in arrivals)
            objects += [parse_held_object(m.text) for a in arrivals for m in a.markers]


@given(st.floats(-1.0, 1.0), st.floats(0.0, 100.0))
def test_order_text_round_trips(speed: float, force: float) -> None:
    command = read_order(order_text(Command(speed, force)))
    assert command.speed == pytest.approx(speed, abs=5.1e-5)
    assert command.force == pytest.approx(force, abs=5.1e-4)
    assert read_order(order_text(None)) is None
