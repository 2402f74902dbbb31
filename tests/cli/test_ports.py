"""Messages about available and missing serial ports."""

from __future__ import annotations

from pathlib import Path

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from firstcontact.cli.main import main
from firstcontact.device import ports
from firstcontact.device._twin_source import TwinDevice


def plug(monkeypatch: pytest.MonkeyPatch, *infos: ListPortInfo) -> None:
    monkeypatch.setattr(list_ports, "comports", lambda: list(infos))


def info(device: str, vid: int | None = None, description: str = "n/a") -> ListPortInfo:
    port = ListPortInfo(device)
    port.vid, port.pid, port.description = vid, 0x0483, description
    return port


def test_no_ports_exist(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plug(monkeypatch)
    assert main(["ports"]) == 0
    assert "no serial port found" in (output := capsys.readouterr().out)
    assert "--device twin" in output


def test_a_teensy_comes_first(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plug(
        monkeypatch,
        info("/dev/ttyS0"),
        info("/dev/ttyUSB0", 0x1A86, "USB Serial"),
        info("/dev/ttyACM0", 0x16C0, "USB Serial"),
    )
    assert main(["ports"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split(maxsplit=1) == [
        "/dev/ttyACM0",
        "USB Serial, USB 16C0:0483, looks like a Teensy",
    ]
    assert lines[1].split(maxsplit=1) == ["/dev/ttyS0", "serial port"]
    assert lines[2].split(maxsplit=1) == ["/dev/ttyUSB0", "USB Serial, USB 1A86:0483"]
    assert len(lines) == 3


def test_without_a_teensy_asking_is_offered(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    plug(monkeypatch, info("/dev/ttyUSB0", 0x1A86, "USB Serial"))
    assert main(["ports"]) == 0
    assert "use --ask" in capsys.readouterr().out


def test_asked_a_fingertip_answers_and_what_is_none_does_not(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with TwinDevice() as twin:
        plug(monkeypatch, info(twin.port), info(str(tmp_path / "gone")))
        assert main(["ports", "--ask"]) == 0
    output = capsys.readouterr().out
    assert "a fingertip: firstcontact" in output
    assert "16 channels at 4936 Hz" in output
    assert "there is no such port" in output


def test_access_says_who_may(tmp_path: Path) -> None:
    path = tmp_path / "port"
    path.write_text("")
    path.chmod(0o640)
    assert " 640, this user may open it" in ports.access(path)
    assert ports.access(tmp_path / "gone").startswith("missing")
    assert all(ports.groups())
