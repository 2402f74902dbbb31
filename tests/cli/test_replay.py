"""``firstcontact replay`` in a separate process, with a host at its port."""

import re
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

import forked
from firstcontact.cli.main import main
from firstcontact.core import Block, fingertip_layout
from firstcontact.device.serial_source import SerialSource
from firstcontact.recording import Header, RecordingWriter


def replaying(recording: Path, *options: object) -> forked.Program:
    return forked.Program("command", "replay", recording, *options, stdout=subprocess.PIPE)


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    path = tmp_path / "recording.mcap"
    data = np.arange(16 * 2000, dtype=np.int16).reshape(2000, 16)
    with RecordingWriter(path, Header(fingertip_layout(), "synthetic")) as writer:
        writer.write(Block(data))
    return path


@pytest.mark.parametrize(
    ("named", "number"), [(True, signal.SIGINT), (False, signal.SIGTERM)], ids=["named", "unnamed"]
)
def test_a_recording_as_a_port_until_it_is_told_to_stop(
    recording: Path, tmp_path: Path, named: bool, number: signal.Signals
) -> None:
    options = ["--speed", "inf", *(["--link", str(tmp_path / "port")] if named else [])]
    with replaying(recording, *options) as process:
        word, port = process.stdout.readline().split()
        assert word == "port:"
        assert (port == str(tmp_path / "port")) == named
        blocks = []
        with SerialSource(port) as source:
            while source.health.samples < 2000:
                blocks += [a.block for a in source.read(60.0)]
        blocks += [a.block for a in source.read(0)]
        process.send_signal(number)
        assert process.wait() == 0
    data = np.concatenate([b.data for b in blocks])
    np.testing.assert_array_equal(data.ravel(), np.arange(16 * 2000, dtype=np.int16))
    assert not Path(port).is_symlink(), "the port goes with the command"


@pytest.mark.parametrize("patient", [True, False])
def test_once_it_leaves_when_a_host_had_all_of_it(
    recording: Path, tmp_path: Path, patient: bool
) -> None:
    port = tmp_path / "port"
    with replaying(recording, "--once", "--speed", "inf", "--link", port) as process:
        process.stdout.readline()
        with SerialSource(str(port)) as source:
            while source.health.samples < 2000:
                source.read(60.0)
            if patient:  # asks again when it hears nothing; else it says stop
                assert process.wait(60.0) == 0
        assert process.wait(60.0) == 0
    assert (source.health.samples, source.health.lost_samples) == (2000, 0)
    assert not port.is_symlink()


def test_a_replay_is_a_device_like_any(recording: Path, tmp_path: Path) -> None:
    port = tmp_path / "port"
    with replaying(recording, "--link", port) as process:
        process.stdout.readline()
        child = forked.firstcontact("info", "--device", port)
        process.terminate()
        assert process.wait(60.0) == 0
    assert child.returncode == 0, child.stderr
    assert re.search(r"^samples +[1-9]\d*, and 0 lost$", child.stdout, re.MULTILINE)
    assert re.search(r"^source +synthetic$", child.stdout, re.MULTILINE)


def test_what_cannot_be_is_refused(
    recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", str(recording), "--link", str(recording)]) == 2
    assert "cannot be created (File exists): choose another name" in capsys.readouterr().err
    assert main(["replay", str(tmp_path / "none.mcap")]) == 2
    assert "none.mcap" in capsys.readouterr().err
    assert main(["replay", str(recording), "--speed", "0"]) == 2
    assert "--speed: " in capsys.readouterr().err
