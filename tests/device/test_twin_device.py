"""The twin on its terminal: what it sends, and what is done to it."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import serial
from numpy.typing import NDArray

from firstcontact.core import Command, InputError
from firstcontact.device import protocol
from firstcontact.device._twin_device import TwinDevice
from firstcontact.device.protocol import Frame, FrameError, FrameType, SamplesFrame, encode
from firstcontact.device.source import Descriptor
from firstcontact.device.twin_words import TOLD, held_object, order_text, peak_text
from firstcontact.twin.filter import DeviceFilter
from firstcontact.twin.stream import TwinStream
from processes import PATIENCE, children, command_line, gone, stop, until

#: A twin that says nothing for so long is dead, s.
DEAD = 60.0


@cache
def expected(samples: int) -> NDArray[np.int16]:
    """What a twin with seed 4 must send, from its first sample on."""
    return DeviceFilter().update(TwinStream(seed=4).read(samples))


class Host:
    """A host with nothing between it and the bytes."""

    def __init__(self, port: str) -> None:
        # As a plain file: it must be raw without a host that makes it so.
        self.fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
        self.said = 0
        self.rest = b""
        self.torn = False  # whether frames may be cut off
        self.samples: list[SamplesFrame] = []
        self.markers: list[tuple[int, str]] = []
        self.counters: list[int] = []

    def close(self) -> None:
        os.close(self.fd)

    def say(self, kind: int, payload: bytes = b"") -> None:
        os.write(self.fd, encode(kind, self.said, payload))
        self.said += 1

    def hear(self) -> list[Frame]:
        """What comes next, at least a byte of it."""
        ready, _, _ = select.select([self.fd], [], [], DEAD)
        assert ready, "the twin has gone silent"
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
        """Listen until a frame of this kind comes."""
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
        """Start, and take so many samples."""
        self.say(FrameType.START)
        self.listen(lambda: self.received >= samples)

    def stop(self) -> tuple[int, int]:
        """Stop; next sample's number and overflow."""
        self.say(FrameType.STOP)
        return protocol.read_stopped(self.until(FrameType.STOPPED).payload)

    @property
    def received(self) -> int:
        return sum(len(s.data) for s in self.samples)

    @property
    def first(self) -> int:
        return self.samples[0].first_sample

    def check(self, stopped: tuple[int, int], right: NDArray[np.int16] | None = None) -> None:
        """Every frame came, every sample is the right one, and the lost ones are counted."""
        assert self.counters == list(range(self.counters[0], self.counters[0] + len(self.counters)))
        right = expected(stopped[0]) if right is None else right
        lost = 0
        number = self.first
        for s in self.samples:
            lost += s.first_sample - number
            assert s.overflow == lost
            number = s.first_sample + len(s.data)
            assert (s.data == right[s.first_sample : number]).all()
        assert self.received + stopped[1] == stopped[0] - self.first
        assert stopped[1] >= lost


@contextmanager
def host(port: str) -> Iterator[Host]:
    made = Host(port)
    try:
        yield made
    finally:
        made.close()


@pytest.fixture
def twin() -> Iterator[TwinDevice]:
    with TwinDevice(seed=4, speed=20) as device:
        yield device


def test_in_real_time_every_sample_comes_and_is_the_twins() -> None:
    with TwinDevice(seed=4) as device, host(device.port) as h:
        h.boot()
        h.start(4 * 4936)
        stopped = h.stop()
        h.check(stopped)
        assert stopped[1] == 0
        # The motor's starts are told, where they are, and how each closing went.
        stream = TwinStream(seed=4)
        stream.read(stopped[0])
        words = [(p.start, f"twin: {p.label.object}") for p in stream.pinches]
        words += [(p.end, f"twin: peak {p.peak:.1f} N") for p in stream.pinches if p.end]
        assert h.markers == sorted(w for w in words if h.first <= w[0] < stopped[0])
        assert len(h.markers) >= 3


def test_faster_than_real_time_all_is_received_or_counted(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.start(100_000)
        h.check(h.stop())


def test_a_host_that_stalls_loses_what_is_counted(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.start(1000)
        # Looks elsewhere for longer than the device can keep.
        select.select([], [], [], 1.5)
        h.listen(lambda: h.samples[-1].overflow > 0)
        stopped = h.stop()
        assert stopped[1] > 0
        h.check(stopped)


def test_pyserial_opens_it_like_any_port(twin: TwinDevice) -> None:
    with serial.Serial(twin.port, 115_200, timeout=DEAD, exclusive=True) as port:
        port.write(encode(FrameType.HELLO, 0, b"\1"))
        frame = protocol.decode(port.read_until(b"\0")[:-1])
        text = protocol.read_descriptor(frame.payload)[2]
        descriptor = Descriptor.from_text(text)
        assert descriptor.source == "twin"
        assert len(descriptor.layout.channels) == 16


def test_a_host_that_leaves_and_comes_back_finds_the_same_device(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        boot = h.boot()
        h.start(500)
        end, _ = h.stop()
    with host(twin.port) as h:
        assert h.boot() == boot
        h.start(500)
        assert h.first >= end
        h.check(h.stop())


def test_a_reset_begins_another_boot_at_sample_0_on_the_same_port() -> None:
    switched_on = time.monotonic()
    with TwinDevice(seed=4, speed=20) as twin, host(twin.port) as h:
        boot = h.boot()
        h.start(50_000)
        before = h.samples[-1].first_sample
        twin.reset()
        h.torn = True
        assert h.boot() != boot
        h.samples.clear()
        h.counters.clear()
        h.torn = False
        h.start(2000)
        # All that the device ever counted fits into the time that it was on for.
        on_for = time.monotonic() - switched_on
        assert before + h.first < on_for * 20 * 4936
        assert h.counters[0] == 1, "the descriptor was the first frame"
        stopped = h.stop()
        assert h.counters == list(range(1, len(h.counters) + 1))
        # It has begun anew at some scan of the hand, which went on: at which one, the piezo
        # tells, whose filter has no long memory.
        whole = expected(round(on_for * 20 * 4936) + stopped[0])
        first = max(h.first, 200)
        seen = np.concatenate([f.data for f in h.samples])[first - h.first :][:400, :2]
        (places,) = np.nonzero((whole[:-400, :2] == seen[0]).all(axis=1))
        fits = [k for k in places if (whole[k : k + 400, :2] == seen).all()]
        assert len(fits) == 1
        origin = int(fits[0]) - first
        assert origin > before
        scans = TwinStream(seed=4).read(origin + stopped[0])
        h.check(stopped, DeviceFilter().update(scans[origin:]))


def test_a_pulled_cable_ends_the_port_and_comes_back_under_its_name(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        boot = h.boot()
        h.start(500)
        end = h.samples[-1].first_sample
        twin.unplug()
        assert not Path(twin.port).exists()
        with pytest.raises(OSError, match="Input/output error"):
            os.write(h.fd, b"\0")
        twin.unplug()
    twin.plug()
    twin.plug()
    with host(twin.port) as h:
        assert h.boot() == boot
        h.start(500)
        assert h.first > end


def test_the_hand_takes_what_it_is_told_to(twin: TwinDevice) -> None:
    with host(twin.port) as h:
        h.say(FrameType.ORDER, b"object: block 29")
        told = protocol.read_marker(h.until(FrameType.MARKER).payload)[0]
        h.start(1)

        def taken() -> list[str]:
            there = [text for sample, text in h.markers if sample > told]
            return [t for t in there if held_object(t) is not None]

        h.listen(lambda: len(taken()) >= 3)
        # The piece of stream that was made already may hold one start more.
        assert taken()[1:3] == ["twin: block 29"] * 2
        h.say(FrameType.ORDER, b"object: pear")
        h.listen(lambda: any("'pear' is not known" in text for _, text in h.markers))
        h.say(FrameType.ORDER, b"object: any")
        before = len(taken())
        h.listen(lambda: len(taken()) >= before + 5)
        assert set(taken()[before + 1 :]) != {"twin: block 29"}


def test_only_the_objects_that_were_given_are_taken() -> None:
    with TwinDevice(objects=["block 10", "apple 1"], speed=20) as twin, host(twin.port) as h:
        h.start(1)
        h.listen(lambda: len(h.markers) >= 8)
        assert {held_object(text) for _, text in h.markers} == {"block 10", "apple 1", None}


class Squeezed:
    """What a host saw of each closing: its object, and how hard it was squeezed."""

    def __init__(self, h: Host) -> None:
        self.h = h

    def starts(self) -> list[tuple[int, str]]:
        """Sample and object of each closing that was told to begin."""
        held = [(sample, held_object(text)) for sample, text in self.h.markers]
        return [(sample, name) for sample, name in held if name is not None]

    def peaks(self) -> dict[int, float]:
        """Of each closing that is over, by the sample that it began at."""
        found: dict[int, float] = {}
        for end, text in self.h.markers:
            before = [start for start, _ in self.starts() if start < end]
            if text.startswith("twin: peak ") and before:
                found[before[-1]] = float(text.split()[2])
        return found

    def ordered(self, order: Command | None, within: int) -> tuple[int, int, int]:
        """Order something of each closing until one hears it so many samples after its start.

        Its number among the closings seen, its start, and the sample that the order came at.
        """
        text = order_text(order)
        answer = f"{TOLD}{text}"
        while True:
            n = len(self.starts())
            self.h.listen(lambda n=n: len(self.starts()) > n)
            start = self.starts()[-1][0]
            self.h.say(FrameType.ORDER, text.encode())
            self.h.listen(
                lambda s=start: any(at > s and said.endswith(text) for at, said in self.h.markers)
            )
            answers = ((at, t) for at, t in self.h.markers if at > start and t.endswith(text))
            came, said = next(answers)
            if said != answer:
                continue  # it came when the hand had begun to open
            if came - start < within:
                return len(self.starts()) - 1, start, came


def test_a_commanded_closing_presses_less_than_it_would_have() -> None:
    stream = TwinStream(seed=4)
    while len(stream.pinches) < 20 or stream.pinches[-1].end is None:
        stream.read(1000)
    drawn = [p.start for p in stream.pinches]
    with TwinDevice(seed=4) as device, host(device.port) as h:
        h.start(1)
        seen = Squeezed(h)
        number, start, _ = seen.ordered(Command(0.03, 1.0), 900)
        h.listen(lambda: len([s for s in seen.peaks() if s >= start]) >= 3)
        # Nothing before the first start that was seen was commanded.
        number += drawn.index(seen.starts()[0][0])
        there = list(stream.pinches)[number : number + 3]
        after = [s for s in seen.starts() if s[0] >= start][:3]
        assert [p.label.object for p in there] == [name for _, name in after]
        told, *others = [seen.peaks()[s] for s, _ in after]
        alone = [round(p.peak or 0.0, 1) for p in there]
        assert told < 0.6 * alone[0]
        assert others == alone[1:]


def test_a_release_opens_the_hand_after_the_latency() -> None:
    with TwinDevice(seed=4, latency=0.010) as device, host(device.port) as h:
        h.start(1)
        seen = Squeezed(h)
        _, start, came = seen.ordered(None, 2500)
        h.listen(lambda: start in seen.peaks())
        end = next(at for at, said in h.markers if at > start and "peak" in said)
        # To the next piece, and no longer.
        assert 0 <= end - came - round(0.010 * 4936) <= 50


@pytest.mark.parametrize(
    "text",
    ["hand:", "hand: 1", "hand: 1 2 3", "hand: nan 1", "hand: 1 inf", "hand: halt", "hand:\0", "?"],
)
def test_an_order_that_is_none_is_answered_and_changes_nothing(twin: TwinDevice, text: str) -> None:
    with host(twin.port) as h:
        h.start(1)
        h.say(FrameType.ORDER, text.encode())
        h.listen(lambda: any("twin: hand order" in said for _, said in h.markers))
        h.check(h.stop())


def test_a_command_to_a_hand_at_rest_is_answered() -> None:
    with TwinDevice(seed=4) as device, host(device.port) as h:
        h.start(1)
        while not any("twin: hand is not closing, command 1" in said for _, said in h.markers):
            # Told as soon as it begins to open; it opens and rests for most of a second.
            h.until(FrameType.MARKER)
            if "peak" in h.markers[-1][1]:
                h.say(FrameType.ORDER, b"hand: 0.0 0.0")


def test_no_mark_is_an_order() -> None:
    """Whoever sets a marker, a viewer of the page too, moves nothing with it."""
    with TwinDevice(seed=4, objects=["block 10", "apple 1"]) as device, host(device.port) as h:
        h.start(1)
        texts = ("object: block 10", "hand: release", "hand: 0.0 0.0", "twin: told hand: 0.0 0.0")

        def hand() -> list[tuple[int, str]]:
            return [(at, said) for at, said in h.markers if said not in texts]

        while sum("peak" in said for _, said in hand()) < 3:
            h.until(FrameType.MARKER)
            if "peak" not in h.markers[-1][1] and h.markers[-1][1] not in texts:
                for text in texts:  # as a closing begins
                    h.say(FrameType.MARK, text.encode())
        assert {said for _, said in h.markers} >= set(texts)
        # The hand does what it would have done unasked.
        stream = TwinStream("paper-rig", ["block 10", "apple 1"], seed=4)
        while len([p for p in stream.pinches if p.end]) < 20:
            stream.read(1000)
        alone = [(p.start, f"twin: {p.label.object}") for p in stream.pinches]
        alone += [(p.end, peak_text(p.peak)) for p in stream.pinches if p.end and p.peak]
        assert set(hand()) <= set(alone)


def test_ctrl_c_is_not_for_the_twin(twin: TwinDevice) -> None:
    assert os.getsid(twin.pid) != os.getsid(0), "not in the group that the terminal signals"
    os.kill(twin.pid, signal.SIGINT)
    with host(twin.port) as h:
        h.boot()


PARENT = """
import sys
from firstcontact.device._twin_device import TwinDevice
device = TwinDevice()
print(device.pid, device.port, flush=True)
sys.stdin.read()
"""


def test_the_twin_dies_with_a_parent_that_is_killed() -> None:
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", PARENT], stdin=pipe, stdout=pipe) as parent:
        assert parent.stdout is not None
        pid, port = parent.stdout.readline().split()
        assert Path(port.decode()).exists()
        parent.kill()
    assert gone(int(pid))
    # The folder of its port stays until the next one starts, once it is old enough to be nobody's.
    left = Path(port.decode()).parent
    assert left.exists()
    os.utime(left, (0, 0))
    with TwinDevice(speed=20) as another:
        os.utime(Path(another.port).parent, (0, 0))
        with TwinDevice(speed=20):
            assert Path(another.port).exists(), "it is in use, however old"
    assert not left.exists()


def test_a_twin_that_stands_still_is_closed_all_the_same() -> None:
    device = TwinDevice(speed=20)
    stop(device.pid)
    device.close()
    assert gone(device.pid)
    assert not Path(device.port).parent.exists()


def twins(parent: int) -> list[int]:
    """A process's children that are twins: others come and go, such as ``uname``."""
    return [pid for pid in children(parent) if b"twin_process" in command_line(pid)]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_twin_that_hangs_at_its_start_holds_nobody_up(number: signal.Signals) -> None:
    code = "from firstcontact.cli.main import main; raise SystemExit(main())"
    arguments = ["info", "--device", "twin"]
    with subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as parent:
        until(lambda: twins(parent.pid))
        (pid,) = twins(parent.pid)
        stop(pid)
        parent.send_signal(number)
        _, said = parent.communicate(timeout=PATIENCE)
    assert parent.returncode == 128 + number
    assert said == b"firstcontact: interrupted\n"
    assert gone(pid)


def test_a_twin_that_is_terminated_takes_its_port_away(twin: TwinDevice) -> None:
    os.kill(twin.pid, signal.SIGTERM)
    assert gone(twin.pid)
    assert not Path(twin.port).parent.exists()
    with pytest.raises(InputError, match="has ended"):
        twin.reset()


def test_a_closed_twin_is_gone() -> None:
    twin = TwinDevice(speed=20)
    twin.close()
    twin.close()
    assert gone(twin.pid)
    assert not Path(twin.port).exists()
    with pytest.raises(InputError, match="has ended"):
        twin.unplug()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"condition": "lab"}, "condition 'lab' is not known"),
        ({"objects": ["pear"]}, "object 'pear' is not known"),
        ({"seed": -1}, "seed is -1"),
        ({"speed": 0.0}, "speed is 0"),
        ({"latency": -1.0}, "latency is -1"),
        ({"speed": float("nan")}, "speed is nan"),
    ],
)
def test_what_cannot_be_is_refused(arguments: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        TwinDevice(**arguments)  # type: ignore[arg-type]
