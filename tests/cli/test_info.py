"""What a report of a problem needs: ``info``, the log, and messages about ports."""

import logging
import platform
import re
from importlib.metadata import version
from pathlib import Path

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo
from tqdm import tqdm

from firstcontact.cli.logs import logged
from firstcontact.cli.main import main
from firstcontact.device.twin_process import TwinOptions
from firstcontact.device.twin_source import TwinDevice


def fields(text: str) -> dict[str, str]:
    lines = (line.split(maxsplit=1) for line in text.splitlines() if not line.startswith(" "))
    return {line[0]: line[-1] for line in lines}


def test_versions_and_platform(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info"]) == 0
    captured = fields(capsys.readouterr().out)
    assert captured["firstcontact"] == version("firstcontact")
    assert captured["Python"].startswith(platform.python_version())
    assert captured["platform"] == platform.platform()
    for name in ("numpy", "pyserial", "mcap", "websockets"):
        assert captured[name] in (version(name), "not installed")
    assert "pytest" not in captured
    assert "device" not in captured


def test_a_device_reports_its_identity_and_samples(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "--device", "twin"]) == 0
    captured = fields(capsys.readouterr().out)
    assert captured["firmware"].startswith(f"firstcontact {version('firstcontact')}")
    assert captured["source"] == "twin"
    assert captured["rate"].startswith("4936 Hz")
    assert captured["channels"].startswith("16 (int16): piezo_index, ")
    assert int(captured["samples"].split(",")[0]) > 0
    assert captured["frames"] == "0 damaged, 0 lost, 0 doubled"
    assert captured["epochs"] == "1"
    assert not {"numpy", "platform", "ports"} & set(captured)  # those are of info without a device


LOG = logging.getLogger("firstcontact.somewhere")


@pytest.mark.parametrize(
    ("verbose", "displayed"), [(False, ["careful"]), (True, ["begun", "careful"])]
)
def test_only_warnings_are_printed_unless_verbose(
    verbose: bool, displayed: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    with logged(verbose):
        LOG.info("begun\x1b[31m")
        LOG.warning("careful")
    LOG.info("nobody listens")
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == len(displayed)
    for line, word in zip(lines, displayed, strict=True):
        assert word in line
        assert "firstcontact.somewhere" in line
        assert "\x1b" not in line


def test_a_warning_beside_a_progress_bar_gets_a_separate_line(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with logged(False), tqdm(total=3, desc="pinches") as bar:
        LOG.warning("careful")
        bar.update(3)
    written = re.split(r"[\r\n]+", capsys.readouterr().err)
    (line,) = (part for part in written if "careful" in part)
    assert re.fullmatch(r"\S+Z firstcontact.somewhere: careful", line)
    assert any("3/3" in part for part in written)


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
    with TwinDevice(TwinOptions()) as twin:
        plug(monkeypatch, info(twin.port), info(str(tmp_path / "gone")))
        assert main(["ports", "--ask"]) == 0
    output = capsys.readouterr().out
    assert "a fingertip: firstcontact" in output
    assert "16 channels at 4936 Hz" in output
    assert "there is no port" in output
