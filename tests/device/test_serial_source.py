"""Tests of a device on a port: samples, markers, damaged lines and wrong rates."""

import os
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from numbered import DESCRIPTOR
from scripted_device import DEAD, ScriptedDevice, collect, every_other, read_until, samples

from firstcontact.core import InputError
from firstcontact.device import Arrival, Descriptor, serial_source
from firstcontact.device.ports import SerialTransport
from firstcontact.device.protocol import FrameType, encode
from firstcontact.device.serial_source import SerialSource
from firstcontact.recording import Marker
from processes import until


def test_all_samples_and_control_bytes_arrive(device: ScriptedDevice) -> None:
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


def test_read_waits_for_the_requested_samples(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        count = 0
        for least in (1, 5, 40, 200):
            feeding = threading.Thread(target=lambda n=least: [device.put(5) for _ in range(n)])
            feeding.start()
            arrivals = source.read(60.0, least)
            assert sum(len(a.block.data) for a in arrivals) >= least
            feeding.join()
            count += sum(len(a.block.data) for a in arrivals)
        sent_count = 5 * (1 + 5 + 40 + 200)
        arrivals += collect(source, lambda n: n == sent_count - count)
        assert arrivals[-1].block.end == sent_count
        # Fewer come, too, when the wait is over.
        device.put(5)
        few: list[Arrival] = []
        while not few:
            few = source.read(0.01, 1000)
        assert few[0].block.first_sample == sent_count


def test_stop_of_this_process_while_it_closes_loses_no_samples(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, closing, never = SerialTransport.read, threading.Event(), threading.Event()
    stops = iter([1.2 * serial_source.SILENCE])

    def stop_once(transport: SerialTransport, *patience: float) -> bytes:
        if not closing.wait(1e-3):
            return b""
        for seconds in stops:
            never.wait(seconds)
            return b""
        return read(transport, *patience)

    with SerialSource(device.port) as source:
        monkeypatch.setattr(SerialTransport, "read", stop_once)
        device.put(100)
        closing.set()
    assert samples(source.read(0)) == 100


def test_stalled_host_loses_nothing(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        stalled = 5 * 4936
        for _ in range(5):
            device.put(4936)
        # Nobody reads, but it comes off the line: a device keeps nothing for long.
        until(lambda: source.health.samples >= stalled)
        assert samples(collect(source, lambda n: n == stalled)) == stalled
    assert source.health.lost_samples == source.health.overflow_samples == 0


def test_running_stream_of_another_host_is_taken_over(device: ScriptedDevice) -> None:
    first = SerialTransport(device.port)
    first.send(FrameType.START)
    device.put(2005)
    until(first.read)  # it streams
    first.close()
    # Some of it still waits on the line, and the first frame of it is cut.
    with SerialSource(device.port) as source:
        device.put(1000)
        arrivals = collect(source, lambda n: n >= 1000)
    arrivals += source.read(0)
    assert arrivals[-1].block.end == 3005
    assert source.health.lost_frames == source.health.lost_samples == 0
    assert source.health.bad_frames == 0


def test_marks_return_with_their_sample(device: ScriptedDevice) -> None:
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
        read_until(source, lambda: not source.health.connected)
        with pytest.raises(InputError, match="marker"):
            source.mark("lost")


def test_unopened_source_can_be_closed() -> None:
    source = SerialSource("nowhere")
    assert source.health.samples == 0
    with pytest.raises(InputError, match="nowhere is not open"):
        _ = source.descriptor
    source.close()


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
def test_damage_loses_only_its_frames(
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


RATE = DESCRIPTOR.layout.rate
REAL = replace(DESCRIPTOR, source="real")


#: Samples that are surely enough, however busy this machine is.
MANY = round(60 * RATE)


def read(
    tmp_path: Path, rate: float, enough: Callable[[int], bool], descriptor: Descriptor = REAL
) -> None:
    """Read a device that sends at ``rate`` Hz until there are enough samples."""
    with (
        ScriptedDevice(tmp_path / "port", descriptor=descriptor) as device,
        SerialSource(device.port) as source,
        device.sending(rate),
    ):
        collect(source, enough)


def test_rate_off_by_3_percent_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serial_source, "OPENING", 60.0)
    with pytest.raises(InputError, match=r"\b5\d{3} .*\b4936\b") as refusal:
        read(tmp_path, 1.03 * RATE, lambda n: n >= MANY)
    assert str(tmp_path / "port") in str(refusal.value)


@pytest.mark.parametrize("descriptor", [replace(REAL, paced=False), DESCRIPTOR])
def test_rate_is_not_checked_without_real_time(descriptor: Descriptor, tmp_path: Path) -> None:
    read(tmp_path, 4 * RATE, lambda n: n >= round(6 * RATE), descriptor)


def test_reconnected_cable_starts_an_epoch_and_counts_losses(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(700)
        first_epoch = collect(source, lambda n: n == 700)
        device.unplug()
        assert not read_until(source, lambda: not source.health.connected)
        device.count_samples(300)
        device.plug()
        read_until(source, lambda: source.health.connected)
        device.put(1000)
        second_epoch = collect(source, lambda n: n >= 1000)
        assert {a.block.epoch for a in first_epoch} == {0}
        assert {a.block.epoch for a in second_epoch} == {1}
        assert source.health.reconnects == 1
    health = source.health
    # The device kept its power: nothing is unaccounted for.
    assert health.samples + health.lost_samples == device.next_sample == 2000
    assert health.bad_frames == 0


def test_power_loss_restarts_at_sample_0(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(700)
        collect(source, lambda n: n == 700)
        for boot in (2, 3):
            device.unplug()
            read_until(source, lambda: not source.health.connected)
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
def test_reset_starts_an_epoch_on_the_open_port(device: ScriptedDevice, boot: int) -> None:
    """This also holds for devices that cannot count their starts."""
    with SerialSource(device.port) as source:
        device.put(700)
        collect(source, lambda n: n == 700)
        device.reset(boot)
        # An answer from before the reset may make the host start the device without knowing of it.
        read_until(source, lambda: source.health.reconnects == 1)
        device.put(100)
        arrivals = collect(source, lambda n: n == 100)
        assert {(a.block.epoch, a.block.first_sample) for a in arrivals[:1]} == {(1, 0)}
    assert source.health.reconnects == 1
    assert source.health.samples == 800
    assert source.health.lost_samples == 0


def test_silent_device_is_polled_and_keeps_its_epoch(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", 0.05)
    requests = []

    def hears(data: bytes) -> bytes:
        requests.append(data)
        return data

    with SerialSource(device.port) as source:
        device.put(700)
        collect(source, lambda n: n == 700)
        device.script.hears = hears
        read_until(source, lambda: len(requests) > 4)
        device.put(700)
        collect(source, lambda n: n == 700)
    assert source.health.reconnects == 0
    assert source.health.lost_samples == source.health.lost_frames == 0


def test_dead_device_is_disconnected_until_it_answers(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", 0.1)
    monkeypatch.setattr(serial_source, "AGAIN", 0.1)
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)
        device.script.hears = lambda data: b""
        read_until(source, lambda: not source.health.connected)
        device.script.hears = lambda data: data
        monkeypatch.setattr(serial_source, "SILENCE", DEAD)
        device.put(100)
        collect(source, lambda n: n == 100)
        assert source.health.connected


def test_lost_start_is_repeated(device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", 0.1)
    start = encode(FrameType.START, 1)
    device.script.hears = lambda data: data.replace(start, b"")
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)
