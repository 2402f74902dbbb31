"""Tests of orders to the twin's hand, and of the texts between host and twin."""

from __future__ import annotations

import select
from collections.abc import Iterator
from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st
from twin_host import Host, host

from firstcontact.core import Command, InputError
from firstcontact.device import (
    FrameType,
    concerns_hand,
    held_object,
    lost_object,
    object_text,
    order_text,
)
from firstcontact.device import _protocol as protocol
from firstcontact.device._twin_source import TwinDevice, TwinSource
from firstcontact.device._twin_words import ACCEPTED, lost_text, peak_text, read_order
from firstcontact.twin import TwinStream
from firstcontact.twin._objects import OBJECTS

#: Multiple of real time at which orders still arrive within a closing.
SPEED = 4


@pytest.fixture
def twin() -> Iterator[TwinDevice]:
    with TwinDevice(seed=4, speed=20) as device:
        yield device


def test_order_selects_the_object(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.say(FrameType.ORDER, b"object: block 29")
        order_sample = protocol.read_marker(h.until(FrameType.MARKER).payload)[0]
        h.start(1)

        def held_texts() -> list[str]:
            texts = [text for sample, text in h.markers if sample > order_sample]
            return [t for t in texts if held_object(t) is not None]

        h.listen(lambda: len(held_texts()) >= 3)
        # The piece of stream that was made already may hold one start more.
        assert held_texts()[1:3] == ["twin: block 29"] * 2
        h.say(FrameType.ORDER, b"object: pear")
        h.listen(lambda: any("'pear' is not known" in text for _, text in h.markers))
        h.say(FrameType.ORDER, b"object: any")
        count = len(held_texts())
        h.listen(lambda: len(held_texts()) >= count + 5)
        assert set(held_texts()[count + 1 :]) != {"twin: block 29"}


class ClosingLog:
    """Record of each closing as the host sees it: object and largest force."""

    def __init__(self, h: Host) -> None:
        self.h = h

    def starts(self) -> list[tuple[int, str]]:
        """Sample and object of each announced closing."""
        objects = [(sample, held_object(text)) for sample, text in self.h.markers]
        return [(sample, name) for sample, name in objects if name is not None]

    def peaks(self) -> dict[int, float]:
        """Largest force of each finished closing, by the sample at which it began."""
        peak_forces: dict[int, float] = {}
        for end, text in self.h.markers:
            starts = [start for start, _ in self.starts() if start < end]
            if text.startswith("twin: peak ") and starts:
                peak_forces[starts[-1]] = float(text.split()[2])
        return peak_forces

    def send_order(self, order: Command | None, within: int) -> tuple[int, int, int]:
        """Send an order in each closing until one gets it within ``within`` samples of its start.

        Return the number of that closing, its start, and the sample of the order.
        """
        text = order_text(order)
        answer = f"{ACCEPTED}{text}"
        while True:
            n = len(self.starts())
            self.h.listen(lambda n=n: len(self.starts()) > n)
            start = self.starts()[-1][0]
            self.h.say(FrameType.ORDER, text.encode())
            self.h.listen(
                lambda s=start: any(
                    at > s and content.endswith(text) for at, content in self.h.markers
                )
            )
            answers = ((at, t) for at, t in self.h.markers if at > start and t.endswith(text))
            order_at, content = next(answers)
            if content != answer:
                continue  # it came when the hand had begun to open
            if order_at - start < within:
                return len(self.starts()) - 1, start, order_at


def read_past(stream: TwinStream, sample: int) -> None:
    """Simulate the stream beyond a sample."""
    while stream.sample <= sample:
        stream.read(1000)


def test_command_lowers_the_peak_of_its_closing_only() -> None:
    stream = TwinStream(seed=4)
    with TwinDevice(seed=4, speed=SPEED) as device, host(device.port) as h:
        h.start(1)
        log = ClosingLog(h)
        number, start, _ = log.send_order(Command(0.03, 1.0), 900)
        h.listen(lambda: len([s for s in log.peaks() if s >= start]) >= 3)
        # Nothing before the first start that was seen was commanded.
        read_past(stream, log.starts()[0][0])
        number += [p.start for p in stream.pinches].index(log.starts()[0][0])
        while len([p for p in stream.pinches if p.end]) < number + 3:
            stream.read(1000)
        expected = list(stream.pinches)[number : number + 3]
        starts = [s for s in log.starts() if s[0] >= start][:3]
        assert [p.label.object for p in expected] == [name for _, name in starts]
        commanded_peak, *later_peaks = [log.peaks()[s] for s, _ in starts]
        expected_peaks = [round(p.peak or 0.0, 1) for p in expected]
        assert commanded_peak < 0.6 * expected_peaks[0]
        assert later_peaks == expected_peaks[1:]


def test_release_opens_the_hand_after_the_latency() -> None:
    with TwinDevice(seed=4, speed=SPEED, latency=0.010) as device, host(device.port) as h:
        h.start(1)
        log = ClosingLog(h)
        _, start, release_sample = log.send_order(None, 2500)
        h.listen(lambda: start in log.peaks())
        end = next(at for at, content in h.markers if at > start and "peak" in content)
        # To the next piece, and no longer.
        assert 0 <= end - release_sample - round(0.010 * 4936) <= 50


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
        h.check(h.stop())


def test_a_command_to_a_hand_at_rest_is_answered() -> None:
    with TwinDevice(seed=4, speed=SPEED) as device, host(device.port) as h:
        h.start(1)
        while not any(
            "twin: hand is not closing, command 1" in content for _, content in h.markers
        ):
            # Told as soon as it begins to open; it opens and rests for most of a second.
            h.until(FrameType.MARKER)
            if "peak" in h.markers[-1][1]:
                h.say(FrameType.ORDER, b"hand: 0.0 0.0")


def test_marks_are_not_orders() -> None:
    """A program or viewer that sets markers cannot move the hand."""
    with (
        TwinDevice(seed=4, speed=SPEED, objects=["block 10", "apple 1"]) as device,
        host(device.port) as h,
    ):
        h.start(1)
        texts = ("object: block 10", "hand: release", "hand: 0.0 0.0", "twin: told hand: 0.0 0.0")

        def hand() -> list[tuple[int, str]]:
            return [(at, content) for at, content in h.markers if content not in texts]

        while sum("peak" in content for _, content in hand()) < 3:
            h.until(FrameType.MARKER)
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
    with TwinSource(seed=4, speed=50) as source:
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
            objects += [held_object(m.text) for a in arrivals for m in a.markers]


@given(st.floats(-1.0, 1.0), st.floats(0.0, 100.0))
def test_order_text_round_trips(speed: float, force: float) -> None:
    command = read_order(order_text(Command(speed, force)))
    assert command is not None
    assert command.speed == pytest.approx(speed, abs=5.1e-5)
    assert command.force == pytest.approx(force, abs=5.1e-4)
    assert read_order(order_text(None)) is None


@given(st.text(max_size=30))
def test_other_hand_texts_are_refused_or_ignored(text: str) -> None:
    try:
        order = read_order("hand:" + text)
    except InputError:
        return
    assert order is None or (isfinite(order.speed) and isfinite(order.force))


def test_object_texts_differ_from_hand_texts() -> None:
    for name in OBJECTS:
        assert held_object(f"twin: {name}") == name
        assert not concerns_hand(f"twin: {name}")
    about = (peak_text(3.44), ACCEPTED + order_text(None), ACCEPTED + object_text("apple 1"))
    for text in (*about, "twin: hand is not closing", "hand: release", "hand: -0.0160 2.551"):
        assert held_object(text) is None
        assert concerns_hand(text)
    for text in ("an apple", "hand: my left one", "hand: 0.0160 2.551 or so"):
        assert held_object(text) is None
        assert not concerns_hand(text)
    assert peak_text(3.44) == "twin: peak 3.4 N"


def test_loss_texts_concern_the_hand() -> None:
    for loss in ("dropped", "broken"):
        assert lost_object(lost_text(loss)) == loss
        assert concerns_hand(lost_text(loss))
        assert held_object(lost_text(loss)) is None
    assert lost_object(peak_text(3.0)) is None
