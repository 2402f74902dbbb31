"""Messages about available and missing serial ports."""

from pathlib import Path

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from firstcontact.cli.main import main
from firstcontact.device.twin_source import TwinDevice


def plug(monkeypatch: pytest.MonkeyPatch, *infos: ListPortInfo) -> None:
    monkeypatch.setattr(list_ports, "comports", lambda: list(infos))


def info(device: str, vid: int | None = None, description: str = "n/a") -> ListPortInfo:
    port = ListPortInfo(device)
    port.vid, port.pid, port.description = vid, 0x0483, description
    return port


def test_ports_are_listed_with_a_teensy_first(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    plug(monkeypatch)
    assert main(["ports"]) == 0
    assert "--device twin" in capsys.readouterr().out
    (mine := tmp_path / "port").touch()
    devices = info("/dev/ttyS0"), info(str(mine), 0x1A86), info("/dev/ttyACM0", 0x16C0)
    plug(monkeypatch, *devices)
    assert main(["ports"]) == 0
    out = capsys.readouterr().out
    names = [line.split()[0] for line in out.splitlines() if line.startswith("/")]
    assert names == ["/dev/ttyACM0", "/dev/ttyS0", str(mine)]
    assert "this user may open it" in out


def test_asked_a_fingertip_answers_and_what_is_none_does_not(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with TwinDevice() as twin:
        plug(monkeypatch, info(twin.port), info(str(tmp_path / "gone")))
        assert main(["ports", "--ask"]) == 0
    output = capsys.readouterr().out
    assert "a fingertip: firstcontact" in output
    assert "16 channels at 4936 Hz" in output
    assert "there is no port" in output
