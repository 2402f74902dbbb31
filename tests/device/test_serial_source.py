"""Tests of a device on a port: every sample arrives once and in order, markers too."""

from __future__ import annotations

import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest
from numbered import DESCRIPTOR, numbered
from scripted_device import ScriptedDevice, collect
from serial_faults import every_other, read_until, samples

from firstcontact.core import InputError
from firstcontact.device import Arrival, FrameType, SerialSource
from firstcontact.device import _serial_source as serial_source
from firstcontact.device._ports import SerialTransport
from firstcontact.recording import Marker
from processes import PATIENCE, until


@pytest.fixture
def _is_patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the source wait long for a device, because a busy machine may delay it."""
    monkeypatch.setattr(serial_source, "SILENCE", PATIENCE)


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


@pytest.mark.usefixtures("_is_patient")
def test_a_reader_reads_the_port_in_its_own_thread(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    threads: list[tuple[int, int]] = []  # of each read of the port, and its number of bytes
    read = SerialTransport.read
    reader = threading.get_ident()

    def watched(transport: SerialTransport, *patience: float) -> bytes:
        data = read(transport, *patience)
        threads.append((threading.get_ident(), len(data)))
        return data

    with SerialSource(device.port) as source:
        monkeypatch.setattr(SerialTransport, "read", watched)

        def feed() -> None:
            until(lambda: any(thread == reader for thread, _ in threads))
            device.put(2000)

        feeding = threading.Thread(target=feed)
        feeding.start()
        arrivals = source.read(60.0, 2000)
        feeding.join()
        assert sum(len(a.block.data) for a in arrivals) == 2000
        assert {thread for thread, size in threads if size} == {reader}


@pytest.mark.usefixtures("_is_patient")
def test_last_samples_are_read_after_the_end(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(3001)
    assert not source.ended
    assert samples(collect(source, lambda n: n == 3001)) == 3001
    assert source.ended
    assert source.health.lost_samples == 0


def test_stop_of_this_process_while_it_closes_loses_no_samples(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = SerialTransport.read
    stops = iter([1.2 * serial_source.SILENCE])

    def stop_once(transport: SerialTransport, *patience: float) -> bytes:
        if source._closing.is_set() and not (seconds := next(stops, 0.0)):
            return read(transport, *patience)
        time.sleep(seconds if source._closing.is_set() else 1e-3)
        return b""

    with SerialSource(device.port) as source:
        monkeypatch.setattr(SerialTransport, "read", stop_once)
        device.put(100)
    assert samples(source.read(0)) == 100


@pytest.mark.usefixtures("_is_patient")
def test_lost_last_samples_are_counted_on_stop(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(500)
        collect(source, lambda n: n == 500)
        device.script.sends = every_other(1, lambda frame: b"")
        device.put(500)
    assert source.health.lost_samples == 500
    assert source.health.lost_frames == 100
    assert source.health.bad_frames == 0


def test_stalled_host_loses_nothing(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        stalled = 5 * 4936
        for _ in range(5):
            device.put(4936)
        # Nobody reads, but it comes off the line: a device keeps nothing for long.
        while source.health.samples < stalled:
            assert not source._closing.wait(0.01)
        assert samples(collect(source, lambda n: n == stalled)) == stalled
    assert source.health.lost_samples == source.health.overflow_samples == 0


def test_overflow_of_the_device_is_counted_separately(tmp_path: Path) -> None:
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


def test_host_clock_step_changes_nothing(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    with SerialSource(device.port) as source:
        start = time.monotonic()
        device.put(2500)
        arrivals = collect(source, lambda n: n == 2500)
        monkeypatch.setattr(time, "time", lambda: 0.0)
        monkeypatch.setattr(time, "time_ns", lambda: 0)
        device.put(2500)
        arrivals += collect(source, lambda n: n == 2500)
        end = time.monotonic()
    hosts = [start, *(a.host for a in arrivals), end]
    assert hosts == sorted(hosts)
    assert source.health.reconnects == source.health.lost_samples == 0


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


@pytest.mark.usefixtures("_is_patient")
def test_mark_after_the_last_sample_is_returned(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(100)
        source.mark("the end")
    arrivals = collect(source, lambda n: n == 100)
    assert [m.text for m in arrivals[-1].markers] == ["the end"]


def test_unopened_source_can_be_closed() -> None:
    source = SerialSource("nowhere")
    assert source.health.samples == 0
    with pytest.raises(InputError, match="nowhere is not open"):
        _ = source.descriptor
    source.close()


def test_numbered_samples_have_their_formula() -> None:
    assert numbered(2**32 - 1, 2)[:, :2].tolist() == [[-1, -1], [0, 0]]
