"""Tests of a device whose rate differs from its stated rate."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from numbered import DESCRIPTOR
from scripted_device import ScriptedDevice, collect

from firstcontact.core import InputError
from firstcontact.device import Descriptor, SerialSource, _serial_source

RATE = DESCRIPTOR.layout.rate
REAL = replace(DESCRIPTOR, source="real")


#: Samples that are surely enough, however busy this machine is.
MANY = round(60 * RATE)


def read(
    tmp_path: Path,
    rate: float,
    enough: Callable[[int], bool],
    descriptor: Descriptor = REAL,
    hold: float = 0.0,
) -> None:
    """Read a device that sends at ``rate`` Hz until there are enough samples."""
    with (
        ScriptedDevice(tmp_path / "port", descriptor=descriptor) as device,
        SerialSource(device.port) as source,
        device.sending(rate),
    ):
        collect(source, lambda n: n >= round(RATE) or enough(n))
        device.hold(hold)
        collect(source, enough)


def test_rate_off_by_3_percent_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_serial_source, "OPENING", 60.0)
    with pytest.raises(InputError, match=r"\b5\d{3} .*\b4936\b") as refusal:
        read(tmp_path, 1.03 * RATE, lambda n: n >= MANY)
    assert str(tmp_path / "port") in str(refusal.value)


def test_stated_rate_with_a_burst_passes(tmp_path: Path) -> None:
    read(tmp_path, RATE, lambda n: n >= round(2 * RATE), hold=0.6)


@pytest.mark.parametrize("descriptor", [replace(REAL, paced=False), DESCRIPTOR])
def test_rate_is_not_checked_without_real_time(descriptor: Descriptor, tmp_path: Path) -> None:
    read(tmp_path, 4 * RATE, lambda n: n >= round(6 * RATE), descriptor)


def test_rate_change_during_a_session_is_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(_serial_source, "OPENING", 0.0)

    def warnings() -> list[str]:
        return [r.getMessage() for r in caplog.records if r.levelno == logging.WARNING]

    with caplog.at_level(logging.WARNING):
        read(tmp_path, 2 * RATE, lambda n: bool(warnings()) or n >= MANY)
    (message,) = warnings()
    assert "4936" in message


def test_descriptor_without_real_time_round_trips() -> None:
    for paced in (True, False):
        text = replace(REAL, paced=paced).to_text()
        assert Descriptor.from_text(text).paced is paced
        assert ("paced" in text) is not paced  # absent means real time
