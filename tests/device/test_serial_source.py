"""A device on a port: what is done to cables, devices and bytes, and what the host has then."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numbered import DESCRIPTOR, numbered
from scripted_device import ScriptedDevice, collect

from firstcontact.core import InputError
from firstcontact.device import Arrival, protocol, serial_source
from firstcontact.device.decoder import Decoder
from firstcontact.device.protocol import FrameType, decode, encode
from firstcontact.device.serial_source import SerialSource
from firstcontact.device.transport import SerialTransport
from firstcontact.device.twin_source import TwinSource
from firstcontact.recording import Marker


def samples(arrivals: list[Arrival]) -> int:
    return sum(len(a.block.data) for a in arrivals)


def wait_for(source: SerialSource, what: Callable[[], object]) -> list[Arrival]:
    """Read until something is true."""
    arrivals: list[Arrival] = []
    while not what():
        assert not source.ended
        arrivals += source.read(0.05)
    return arrivals


def every_other(count: int, sends: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """Do something to each ``count``-th samples frame but the first."""
    seen = 0

    def change(frame: bytes) -> bytes:
        nonlocal seen
        if decode(frame[:-1]).type != FrameType.SAMPLES:
            return frame
        seen += 1
        return sends(frame) if seen % count == 0 else frame

    return change


def test_every_sample_arrives_and_bytes_that_terminals_eat_survive(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        assert source.name == device.port
        assert source.descriptor == replace(DESCRIPTOR)
        device.put(20_000)
        arrivals = collect(source, lambda n: n == 20_000)
        assert arrivals[0].block.first_sample == 0
        assert source.health.connected
    health = source.health
    assert (health.samples, health.lost_samples, health.lost_frames, health.bad_frames) == (
        20_000, 0, 0, 0
    )  # fmt: skip
    assert not health.connected
    assert source.ended
    assert source.read(0) == []


def test_the_tail_is_read_after_the_end(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(3001)
    assert not source.ended
    assert samples(collect(source, lambda n: n == 3001)) == 3001
    assert source.ended
    assert source.health.lost_samples == 0


def test_lost_tail_is_counted_by_the_last_word(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(500)
        collect(source, lambda n: n == 500)
        device.script.sends = every_other(1, lambda frame: b"")
        device.put(500)
    assert source.health.lost_samples == 500
    assert source.health.lost_frames == 100
    assert source.health.bad_frames == 0


def test_a_host_that_stalls_for_five_seconds_loses_nothing(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        stalled = 5 * 4936
        for _ in range(5):
            device.put(4936)
        # Nobody reads, but it comes off the line: a device keeps nothing for long.
        while source.health.samples < stalled:
            assert not source._closing.wait(0.01)
        assert samples(collect(source, lambda n: n == stalled)) == stalled
    assert source.health.lost_samples == source.health.overflow_samples == 0


def test_what_the_device_drops_is_told_apart(tmp_path: Path) -> None:
    with (
        ScriptedDevice(tmp_path / "port", room=1000) as device,
        SerialSource(device.port) as source,
    ):
        device.put(10)
        collect(source, lambda n: n == 10)
        device.put(1500)
        collect(source, lambda n: n == 1000)
        device.put(10)
        collect(source, lambda n: n == 10)
    assert source.health.samples == 1020
    assert source.health.lost_samples == source.health.overflow_samples == 500
    assert source.health.lost_frames == 0


def test_a_host_clock_that_is_set_back_does_not_matter(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    with SerialSource(device.port) as source:
        before = time.monotonic()
        device.put(2500)
        arrivals = collect(source, lambda n: n == 2500)
        monkeypatch.setattr(time, "time", lambda: 0.0)
        monkeypatch.setattr(time, "time_ns", lambda: 0)
        device.put(2500)
        arrivals += collect(source, lambda n: n == 2500)
        after = time.monotonic()
    hosts = [before, *(a.host for a in arrivals), after]
    assert hosts == sorted(hosts)
    assert source.health.reconnects == source.health.lost_samples == 0


def test_a_cable_pulled_and_plugged_back_begins_an_epoch_and_counts(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(700)
        before = collect(source, lambda n: n == 700)
        device.unplug()
        assert not wait_for(source, lambda: not source.health.connected)
        device.pass_by(300)
        device.plug()
        wait_for(source, lambda: source.health.connected)
        device.put(1000)
        after = collect(source, lambda n: n >= 1000)
        assert {a.block.epoch for a in before} == {0}
        assert {a.block.epoch for a in after} == {1}
        assert source.health.reconnects == 1
    health = source.health
    # The device kept its power: nothing is unaccounted for.
    assert health.samples + health.lost_samples == device.next_sample == 2000
    assert health.bad_frames == 0


def test_a_device_that_lost_its_power_begins_with_sample_0(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(700)
        collect(source, lambda n: n == 700)
        for boot in (2, 3):
            device.unplug()
            wait_for(source, lambda: not source.health.connected)
            device.reset(boot)
            device.plug()
            device.put(100)
            arrivals = collect(source, lambda n: n == 100)
            assert arrivals[0].block.first_sample == 0
            assert {a.block.epoch for a in arrivals} == {boot - 1}
    assert source.health.samples == 900
    assert source.health.lost_samples == 0
    assert source.health.reconnects == 2


@pytest.mark.parametrize("boot", [2, 1])
def test_a_reset_without_losing_the_port(device: ScriptedDevice, boot: int) -> None:
    """Also of a device that cannot count its starts."""
    with SerialSource(device.port) as source:
        device.put(700)
        collect(source, lambda n: n == 700)
        device.reset(boot)
        device.put(100)
        arrivals = collect(source, lambda n: n == 100)
        assert {(a.block.epoch, a.block.first_sample) for a in arrivals[:1]} == {(1, 0)}
    assert source.health.reconnects == 1
    assert source.health.samples == 800
    assert source.health.lost_samples == 0


def test_a_silent_device_is_asked_and_goes_on_in_its_epoch(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", 0.05)
    asked = []

    def hears(data: bytes) -> bytes:
        asked.append(data)
        return data

    with SerialSource(device.port) as source:
        device.put(700)
        collect(source, lambda n: n == 700)
        device.script.hears = hears
        wait_for(source, lambda: len(asked) > 4)
        device.put(700)
        collect(source, lambda n: n == 700)
    assert source.health.reconnects == 0
    assert source.health.lost_samples == source.health.lost_frames == 0


def test_a_device_that_has_died_shows_as_not_connected_and_may_wake(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", 0.1)
    monkeypatch.setattr(serial_source, "AGAIN", 0.1)
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)
        device.script.hears = lambda data: b""
        wait_for(source, lambda: not source.health.connected)
        device.script.hears = lambda data: data
        wait_for(source, lambda: source.health.connected)
        device.put(100)
        collect(source, lambda n: n == 100)


def test_a_start_that_is_lost_is_said_again(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", 0.1)
    start = encode(FrameType.START, 1)
    device.script.hears = lambda data: data.replace(start, b"")
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)


@pytest.mark.parametrize(
    ("change", "bad"),
    [
        (lambda f: f[:20] + bytes([f[20] ^ 1]) + f[21:], 1),
        (lambda f: f[:20] + b"\x55" + f[20:], 1),
        (lambda f: f[:20] + f[21:], 1),
        (lambda f: f[:20] + b"\0" + f[21:], 2),
        (lambda f: os.urandom(1000).replace(b"\0", b"\1") + b"\0", 1),
        (lambda f: b"", 0),
    ],
    ids=["flipped", "inserted", "deleted", "cut", "burst", "gone"],
)
def test_damage_loses_the_frames_it_touches(
    device: ScriptedDevice, change: Callable[[bytes], bytes], bad: int
) -> None:
    device.script.sends = every_other(10, change)
    with SerialSource(device.port) as source:
        device.put(5005)  # 1001 frames, of which 100 are damaged
        collect(source, lambda n: n == 5005 - 500)
    health = source.health
    assert health.lost_frames == 100
    assert health.lost_samples == 500
    assert health.samples == 4505
    assert health.bad_frames == 100 * bad


def test_frames_that_come_twice_are_left_out(device: ScriptedDevice) -> None:
    device.script.sends = every_other(10, lambda frame: frame + frame)
    with SerialSource(device.port) as source:
        device.put(5000)
        collect(source, lambda n: n == 5000)
    assert source.health.doubled_frames == 100
    assert source.health.lost_frames == 0


def test_a_stream_that_another_host_left_running(device: ScriptedDevice) -> None:
    first = SerialTransport(device.port)
    first.send(FrameType.START)
    device.put(2005)
    assert first.read(), "it streams"
    first.close()
    # Some of it still waits on the line, and the first frame of it is cut.
    with SerialSource(device.port) as source:
        device.put(1000)
        arrivals = collect(source, lambda n: n >= 1000)
    arrivals += source.read(0)
    assert arrivals[-1].block.end == 3005
    assert source.health.lost_frames == source.health.lost_samples == 0
    assert source.health.bad_frames == 0


def test_a_port_opened_twice_is_refused_and_the_first_goes_on(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(500)
        with pytest.raises(InputError, match="another program has this port open"):
            SerialSource(device.port).__enter__()
        device.put(500)
        collect(source, lambda n: n == 1000)
    with SerialSource(device.port):
        pass


def test_another_process_is_refused_too(device: ScriptedDevice) -> None:
    script = (
        "import sys\n"
        "from firstcontact.device.serial_source import SerialSource\n"
        "SerialSource(sys.argv[1]).__enter__()"
    )
    with SerialSource(device.port) as source:
        done = subprocess.run(
            [sys.executable, "-c", script, device.port], capture_output=True, text=True
        )
        assert "another program has this port open" in done.stderr
        device.put(500)
        collect(source, lambda n: n == 500)


def answering(kind: FrameType, payload: bytes) -> Callable[[bytes], bytes]:
    return lambda frame: encode(kind, decode(frame[:-1]).counter, payload)


@pytest.mark.parametrize(
    ("kind", "payload", "words"),
    [
        (FrameType.REFUSED, b"\2only 2", "speaks version 2 of the protocol and this program"),
        (
            FrameType.DESCRIPTOR,
            protocol.descriptor_payload(1, DESCRIPTOR.to_text(), 9),
            "speaks version 9 of the protocol and this program",
        ),
        (FrameType.DESCRIPTOR, protocol.descriptor_payload(1, "{}"), "descriptor cannot be used"),
        (
            FrameType.DESCRIPTOR,
            protocol.descriptor_payload(
                1, replace(DESCRIPTOR, layout=replace(DESCRIPTOR.layout, channels=())).to_text()
            ),
            "no piezo channel",
        ),
    ],
)
def test_a_device_that_does_not_fit_is_refused(
    device: ScriptedDevice, kind: FrameType, payload: bytes, words: str
) -> None:
    device.script.sends = answering(kind, payload)
    with pytest.raises(InputError, match=f"{device.port}: .*{words}.*: flash"):
        SerialSource(device.port).__enter__()
    SerialTransport(device.port).close()  # it was let go


def test_other_columns_than_the_layout_has_are_refused(device: ScriptedDevice) -> None:
    short = protocol.samples_payload(0, 0, np.zeros((5, 15), np.int16))
    device.script.sends = every_other(1, answering(FrameType.SAMPLES, short))
    with SerialSource(device.port) as source:
        device.put(500)
        with pytest.raises(InputError, match=r"does not hold 5 samples of 16 channels.*flash"):
            wait_for(source, lambda: False)
        assert source.ended
        with pytest.raises(InputError, match="flash"):
            source.read(0)


def test_another_device_on_the_same_port_is_refused(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(500)
        collect(source, lambda n: n == 500)
        device.unplug()
        wait_for(source, lambda: not source.health.connected)
        faster = replace(DESCRIPTOR, layout=replace(DESCRIPTOR.layout, rate=9872.0))
        device.reset(2, faster)
        device.plug()
        with pytest.raises(InputError, match="other channels or another rate: start again"):
            wait_for(source, lambda: False)


def test_what_does_not_answer_is_refused(device: ScriptedDevice) -> None:
    device.script.hears = lambda data: b""
    with pytest.raises(InputError, match=r"does not answer.*firstcontact ports --ask"):
        SerialSource(device.port, patience=0.2).__enter__()


def test_a_device_that_goes_while_it_is_opened(device: ScriptedDevice) -> None:
    def hears(data: bytes) -> bytes:
        device._terminal.unplug()
        return b""

    device.script.hears = hears
    with pytest.raises(InputError, match="went away while it was opened: plug it in"):
        SerialSource(device.port).__enter__()


def test_a_port_that_is_not_there_and_one_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such port: see `firstcontact ports`"):
        SerialSource(str(tmp_path / "none")).__enter__()
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(InputError, match="cannot be opened as a serial port"):
        SerialSource(str(file)).__enter__()


@pytest.mark.skipif(os.geteuid() == 0, reason="root may open every port")
def test_a_port_without_permission(device: ScriptedDevice) -> None:
    Path(device.port).resolve().chmod(0)
    with pytest.raises(InputError, match="add yourself to its group"):
        SerialSource(device.port).__enter__()


def test_marks_come_back_with_the_sample_they_are_pinned_to(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(125)
        collect(source, lambda n: n == 125)
        source.mark("now: größer")
        pinned: list[tuple[Arrival, Marker]] = []
        while not pinned:
            device.put(5)
            pinned = [(a, m) for a in collect(source, lambda n: n >= 5) for m in a.markers]
        ((arrival, marker),) = pinned
        assert marker.text == "now: größer"
        assert arrival.block.first_sample <= marker.sample < arrival.block.end
        device.unplug()
        wait_for(source, lambda: not source.health.connected)
        with pytest.raises(InputError, match="the marker was not set: plug it in"):
            source.mark("lost")


def test_a_mark_behind_the_last_sample_comes_with_it(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(100)
        source.mark("the end")
    arrivals = collect(source, lambda n: n == 100)
    assert [m.text for m in arrivals[-1].markers] == ["the end"]


def test_closing_while_it_is_unplugged(device: ScriptedDevice) -> None:
    source = SerialSource(device.port)
    with source:
        device.put(100)
        collect(source, lambda n: n == 100)
        device.unplug()
        wait_for(source, lambda: not source.health.connected)
    source.close()
    assert source.ended


def test_a_source_that_was_never_opened() -> None:
    source = SerialSource("nowhere")
    assert source.health.samples == 0
    with pytest.raises(InputError, match="is not open"):
        _ = source.descriptor
    source.close()


def test_whatever_breaks_in_the_thread_is_told_to_the_reader(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)

        def breaks(self: Decoder, data: bytes) -> list[object]:
            raise MemoryError("no more")

        monkeypatch.setattr(Decoder, "feed", breaks)
        with pytest.raises(InputError, match=r"MemoryError.*open it again"):
            wait_for(source, lambda: False)
        assert not source.health.connected


def test_the_twin_unplugged_plugged_back_and_reset() -> None:
    with TwinSource(objects=["block 20"], speed=2) as source:
        assert source.name == "twin"
        assert source.descriptor.source == "twin"
        twin = source.device
        assert twin is not None
        arrivals = wait_for(source, lambda: source.health.samples > 1000)
        twin.unplug()
        arrivals += wait_for(source, lambda: not source.health.connected)
        twin.plug()
        there = source.health.samples
        arrivals += wait_for(source, lambda: source.health.samples > there + 1000)
        twin.reset()
        arrivals += wait_for(source, lambda: source.health.epoch == 2)
    arrivals += source.read(0)
    ends = {0: arrivals[0].block.first_sample}
    missing = 0
    for block in (a.block for a in arrivals):
        # It kept its power and counted on while it was unplugged; after the reset, from 0.
        end = ends.get(block.epoch, ends[0] if block.epoch == 1 else block.first_sample)
        missing += block.first_sample - end
        ends[block.epoch] = block.end
    assert sorted(ends)[:2] == [0, 1]
    health = source.health
    assert health.samples == samples(arrivals)
    assert health.lost_samples >= missing > 0
    assert health.reconnects == 2


def test_numbers_are_what_the_tests_think() -> None:
    assert numbered(2**32 - 1, 2)[:, :2].tolist() == [[-1, -1], [0, 0]]
