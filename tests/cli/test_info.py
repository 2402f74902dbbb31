"""``info`` prints the facts that a bug report needs."""

import platform
from importlib.metadata import version

import pytest

from firstcontact.cli.main import main


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
