"""Tests of failures of a link: errors, markers, ports that vanish."""

import dataclasses
import os
import threading
import time

import pytest
from numbered import DESCRIPTOR
from scripted_device import DEAD, ScriptedDevice, collect, read_until

from firstcontact.core import InputError
from firstcontact.device import ports, serial_source
from firstcontact.device.ports import LinkError, SerialTransport
from firstcontact.device.protocol import FrameType
from firstcontact.device.serial_source import SerialSource
from processes import until


def test_failure_between_reads_is_raised_before_the_end(device: ScriptedDevice) -> None:
    other_descriptor = dataclasses.replace(
        DESCRIPTOR, layout=dataclasses.replace(DESCRIPTOR.layout, rate=1000.0)
    )
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)
        device.unplug()
        device.reset(2, other_descriptor)
        device.plug()
        until(lambda: "reader " + source.name not in {t.name for t in threading.enumerate()})
        # Nobody has read meanwhile: a loop that asks for the end first must not miss it.
        assert not source.ended
        with pytest.raises(InputError, match="port"):
            source.read(0)
        assert source.ended


@pytest.mark.parametrize("reads_samples", [True, False])
def test_marker_after_the_last_sample_is_preserved(
    device: ScriptedDevice, reads_samples: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serial_source, "SILENCE", DEAD)  # a busy machine may delay the device
    arrivals = []
    with SerialSource(device.port) as source:
        device.put(125)
        if reads_samples:
            arrivals += collect(source, lambda n: n == 125)
        source.mark("the end")
    arrivals += source.read(0)
    markers = [marker for arrival in arrivals for marker in arrival.markers]
    assert [(m.sample, m.text, m.epoch) for m in markers] == [(125, "the end", 0)]
    assert sum(len(arrival.block.data) for arrival in arrivals) == 125
    assert all(arrival.block.data.shape[1:] == (16,) for arrival in arrivals)
    assert source.ended


def test_markers_of_an_interrupted_epoch_keep_it(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(125)
        arrivals = collect(source, lambda n: n == 125)
        source.mark("before")
        source.mark("then")
        # It may be reset before it has heard them, or with its answers on the wire.
        device.reset(2)
        arrivals += read_until(source, lambda: source.health.reconnects == 1)
        device.put(100)
        arrivals += collect(source, lambda n: n == 100)
    markers = [marker for arrival in arrivals for marker in arrival.markers]
    assert all((m.sample, m.epoch) == (125, 0) for m in markers)
    assert [m.text for m in markers] == ["before", "then"][: len(markers)]


def test_stop_of_this_process_during_a_write_does_not_lose_the_port(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ports, "WRITE", 0.02)
    transport = SerialTransport(device.port)
    write = os.write

    def stop_after_write(number: int, data: bytes) -> int:
        written = write(number, data)
        wake = time.monotonic() + 0.05
        until(lambda: time.monotonic() > wake)
        return written

    monkeypatch.setattr(os, "write", stop_after_write)
    transport.send(FrameType.STOP)
    transport.close()


def test_device_that_never_reads_is_a_lost_port(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ports, "WRITE", 0.02)
    transport = SerialTransport(device.port)

    def send_without_end() -> None:
        while True:
            transport.send(FrameType.MARK, bytes(200))

    with device.stuck(), pytest.raises(LinkError, match="no bytes"):
        send_without_end()
    transport.close()
