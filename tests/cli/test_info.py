"""What a bug report needs is there."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import Block, fingertip_layout
from firstcontact.recording import Header, RecordingWriter


def fields(said: str) -> dict[str, str]:
    lines = (line.split(maxsplit=1) for line in said.splitlines() if not line.startswith(" "))
    return {line[0]: line[-1] for line in lines}


def test_versions_and_platform(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info"]) == 0
    told = fields(capsys.readouterr().out)
    assert told["firstcontact"] == version("firstcontact")
    assert told["Python"].startswith(platform.python_version())
    assert told["platform"] == platform.platform()
    for name in ("numpy", "pyserial", "mcap", "numba", "websockets"):
        assert told[name] in (version(name), "not installed")
    assert "pytest" not in told
    assert "device" not in told


def test_a_device_says_what_it_is_and_is_listened_to(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["info", "--device", "twin"]) == 0
    told = fields(capsys.readouterr().out)
    assert told["firmware"].startswith(f"firstcontact {version('firstcontact')}")
    assert told["source"] == "twin"
    assert told["rate"].startswith("4936 Hz")
    assert told["channels"].startswith("16 (int16): piezo_index, ")
    assert int(told["samples"].split(",")[0]) > 0
    assert told["frames"] == "0 damaged, 0 lost, 0 doubled"
    assert told["epochs"] == "1"
    assert not {"numpy", "platform", "ports"} & set(told)  # those are of info without a device


def test_a_recording_is_a_device_too(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    path = tmp_path / "short.mcap"
    with RecordingWriter(path, Header(fingertip_layout(), "synthetic", hand="a hand")) as writer:
        writer.write(Block(np.zeros((100, 16), np.int16)))
        writer.write(Block(np.zeros((100, 16), np.int16), 150))
    assert main(["info", "--device", str(path)]) == 0
    told = fields(capsys.readouterr().out)
    assert told["hand"] == "a hand"
    assert told["firmware"] == "not known"
    assert told["samples"] == "200, and 50 lost"


def test_a_port_that_is_not_there(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["info", "--device", str(tmp_path / "none")]) == 2
    said = capsys.readouterr()
    assert "missing" in fields(said.out)["port"]
    assert "there is no such port: see `firstcontact ports`" in said.err
