"""Tests of unplugged, reset and silent devices."""

import pytest
from scripted_device import DEAD, ScriptedDevice, collect, read_until

from firstcontact.device import serial_source as serial_source
from firstcontact.device.protocol import FrameType, encode
from firstcontact.device.serial_source import SerialSource


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
