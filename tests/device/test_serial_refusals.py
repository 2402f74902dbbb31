"""Tests of wrong ports and wrong devices."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numbered import DESCRIPTOR
from scripted_device import ScriptedDevice, answer_frame, collect, every_other, read_until

from firstcontact.core import InputError
from firstcontact.device import protocol
from firstcontact.device.ports import SerialTransport
from firstcontact.device.protocol import Decoder, FrameType
from firstcontact.device.serial_source import SerialSource


def test_second_open_of_a_port_is_refused(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(500)
        with pytest.raises(InputError, match=device.port):
            SerialSource(device.port).__enter__()
        device.put(500)
        collect(source, lambda n: n == 1000)
    with SerialSource(device.port):
        pass


@pytest.mark.parametrize(
    ("kind", "payload", "words"),
    [
        (FrameType.REFUSED, b"\2only 2", "speaks version 2 of the protocol and this program"),
        (
            FrameType.DESCRIPTOR,
            protocol.descriptor_payload(1, DESCRIPTOR.to_text(), 9),
            "speaks version 9 of the protocol and this program",
        ),
        (
            FrameType.DESCRIPTOR,
            protocol.descriptor_payload(1, "{}"),
            "descriptor: Object missing required field",
        ),
        (
            FrameType.DESCRIPTOR,
            protocol.descriptor_payload(
                1, replace(DESCRIPTOR, layout=replace(DESCRIPTOR.layout, channels=())).to_text()
            ),
            "no vibration channel",
        ),
    ],
)
def test_unsupported_device_is_refused(
    device: ScriptedDevice, kind: FrameType, payload: bytes, words: str
) -> None:
    device.script.sends = answer_frame(kind, payload)
    with pytest.raises(InputError, match=f"{device.port}: .*{words}.*: flash"):
        SerialSource(device.port).__enter__()
    SerialTransport(device.port).close()  # it was let go


def test_other_columns_than_the_layout_has_are_refused(device: ScriptedDevice) -> None:
    short = protocol.samples_payload(0, 0, np.zeros((5, 15), np.int16))
    device.script.sends = every_other(1, answer_frame(FrameType.SAMPLES, short))
    with SerialSource(device.port) as source:
        device.put(500)
        with pytest.raises(InputError, match="16 channels"):
            read_until(source, lambda: False)
        assert source.ended
        with pytest.raises(InputError, match="flash"):
            source.read(0)


def test_another_device_on_the_same_port_is_refused(device: ScriptedDevice) -> None:
    with SerialSource(device.port) as source:
        device.put(500)
        collect(source, lambda n: n == 500)
        device.unplug()
        read_until(source, lambda: not source.health.connected)
        faster = replace(DESCRIPTOR, layout=replace(DESCRIPTOR.layout, rate=9872.0))
        device.reset(2, faster)
        device.plug()
        with pytest.raises(InputError, match=device.port):
            read_until(source, lambda: False)


def test_silent_port_is_refused(device: ScriptedDevice) -> None:
    device.script.hears = lambda data: b""
    with pytest.raises(InputError, match=device.port):
        SerialSource(device.port, patience=0.2).__enter__()


def test_device_lost_during_opening_is_refused(device: ScriptedDevice) -> None:
    def hears(data: bytes) -> bytes:
        device.unplug()
        return b""

    device.script.hears = hears
    with pytest.raises(InputError, match=device.port):
        SerialSource(device.port).__enter__()


def test_missing_port_and_plain_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="none"):
        SerialSource(str(tmp_path / "none")).__enter__()
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(InputError, match="file"):
        SerialSource(str(file)).__enter__()
    with pytest.raises(InputError, match=str(tmp_path)):
        SerialSource(str(tmp_path)).__enter__()
    with pytest.raises(InputError, match=os.devnull):
        SerialSource(os.devnull).__enter__()


def test_error_in_the_thread_is_raised_in_read(
    device: ScriptedDevice, monkeypatch: pytest.MonkeyPatch
) -> None:
    with SerialSource(device.port) as source:
        device.put(100)
        collect(source, lambda n: n == 100)

        def breaks(self: Decoder, data: bytes) -> list[object]:
            raise MemoryError("no more")

        monkeypatch.setattr(Decoder, "feed", breaks)
        with pytest.raises(InputError, match=r"MemoryError.*open it again"):
            read_until(source, lambda: False)
        assert not source.health.connected
