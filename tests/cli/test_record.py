"""``firstcontact record`` with the twin on a pseudo terminal, with and without interruptions."""

import os
import signal
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import forked
from firstcontact.cli.main import main
from firstcontact.core import Calibration, Finger, VibrationCalibration
from firstcontact.core.calibration import write_calibration
from firstcontact.recording import load_dataset, read_recording
from firstcontact.recording.dataset import cut

#: Of the twin at rest, V; measured by ``firstcontact calibrate``, so that no test has to.
FLOOR = 0.0017


@pytest.fixture
def calibration(tmp_path: Path) -> Path:
    path = tmp_path / "calibration.json"
    write_calibration(Calibration(tuple(VibrationCalibration(f, FLOOR) for f in Finger)), path)
    return path


def options(out: Path, calibration: Path, pinches: int) -> list[str]:
    return [
        "--object=block 29", "--specimen=b29", "--session=3", f"--pinches={pinches}",
        f"--out={out}", f"--calibration={calibration}", "--speed=8",
    ]  # fmt: skip


STREAMS = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)


@contextmanager
def recording(*arguments: str) -> Iterator[forked.Program]:
    """Start a recording. At the end of the block, end it if it still runs."""
    with forked.Program("command", "record", "--device", "twin", *arguments, **STREAMS) as child:
        try:
            yield child
        finally:
            child.kill()


def read_until(child: subprocess.Popen[str], word: str) -> None:
    """Read the lines of a process up to the first with this word."""
    for line in child.stdout:
        if word in line:
            return
    raise AssertionError(f"it ended without {word!r}: {child.stderr and child.stderr.read()}")


def whole_pinches(path: Path) -> int:
    """Return the number of pinches. Assert that each marked pinch is complete."""
    recording = read_recording(path)
    assert all(cut(recording, mark) is not None for mark in recording.pinches)
    return len(recording.pinches)


@pytest.mark.parametrize(
    "number",
    [
        signal.SIGINT,
        signal.SIGTERM,
        pytest.param(signal.SIGHUP, marks=pytest.mark.slow),
        pytest.param(signal.SIGQUIT, marks=pytest.mark.slow),
    ],
)
def test_a_signal_finishes_the_file_and_the_same_command_goes_on(tmp_path, calibration, number):
    out = tmp_path / "übung"
    with recording(*options(out, calibration, 500)) as child:
        read_until(child, "block 29 1/500")
        child.send_signal(number)
        output_tail, errors = child.communicate()
    assert child.returncode == 128 + number, errors
    assert "is not complete" in output_tail
    assert "Traceback" not in errors
    first = read_recording(out / "session-3.mcap")
    assert not any("not closed" in s for s in first.skipped)
    finished = len(first.pinches)
    assert finished >= 1
    assert main(["record", "--device", "twin", *options(out, calibration, finished + 1)]) == 0
    assert [p.name for p in sorted(out.iterdir())] == ["session-3.mcap", "session-3.part2.mcap"]
    dataset = load_dataset(out)
    assert len(dataset) == finished + 1
    assert dataset.source == "twin"
    assert set(dataset.shore_a.tolist()) == {29.0}  # as the twin knows it
    assert set(dataset.specimens.tolist()) == {"b29"}
    assert all(len(p.truth) == 2 for p in dataset.pinches)
    header = first.header
    assert (header.session, header.calibration.noise(Finger.THUMB)) == ("3", FLOOR)
    assert "object: block 29" in [m.text for m in first.markers]
    # The second part is another stretch of the twin, not the first one again.
    one, other = (load_dataset(p).pinches[0] for p in sorted(out.iterdir()))
    n = min(len(one.data), len(other.data))
    assert not np.array_equal(one.data[:n], other.data[:n])


def test_after_repeated_kills_every_complete_pinch_remains(tmp_path, calibration):
    rng = np.random.default_rng(5)
    out = tmp_path / "out"
    predictions = 0
    for _ in range(3):
        k = predictions + int(rng.integers(1, 3))
        with recording(*options(out, calibration, 500)) as child:
            read_until(child, f"block 29 {k}/500")
            os.kill(child.pid, signal.SIGKILL)
        files = sorted(out.iterdir())
        predictions = sum(whole_pinches(path) for path in files)
        assert any("not closed" in s for s in read_recording(files[-1]).skipped)
        # The mark of a pinch is told when it is written: at most the last one can be missing.
        assert predictions >= k - 1
    wanted = predictions + 1
    assert main(["record", "--device", "twin", *options(out, calibration, wanted)]) == 0
    assert len(load_dataset(out)) == wanted
    assert main(["record", "--device", "twin", *options(out, calibration, wanted)]) == 0
    assert sum(whole_pinches(path) for path in out.iterdir()) == wanted


def test_a_plan_and_two_sessions_become_one_dataset(tmp_path, capsys):
    plan = tmp_path / "plan.csv"
    plan.write_text("object,pinches,specimen,role\nblock 10,1,b10,train\napple 1,1,,test\n")
    out = tmp_path / "out"
    code = main(
        ["record", "--device", "twin", "--plan", str(plan), "--sessions", "2", "--speed", "8",
         "--out", str(out), "--notes", "a note"]
    )  # fmt: skip
    output = capsys.readouterr().out
    assert code == 0, output
    assert [p.name for p in sorted(out.iterdir())] == ["session-1.mcap", "session-2.mcap"]
    dataset = load_dataset(out)
    assert dataset.objects.tolist() == ["block 10", "apple 1"] * 2
    assert dataset.test.tolist() == [False, True] * 2
    assert dataset.sessions.tolist() == ["1", "1", "2", "2"]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ([], "--object: "),
        (["--object=a", "--plan=p.csv"], "--object: "),
        (["--object=lead"], "'lead' is not known"),
        (["--object=block 29", "--pinches=0"], "number from 1 to"),
        (["--object=block 29", "--sessions=2", "--session=monday"], "--session: "),
        (["--object=block 29", f"--sessions={10**30}"], "--sessions: "),
        (["--object=block 29", "--calibration=none.json"], "none.json cannot be read"),
        (["--plan=none.csv"], "none.csv cannot be read"),
        (["--object=block 29", "--session=a\udcff"], "UTF-8 cannot store"),
    ],
)
def test_what_cannot_be_recorded_is_refused(tmp_path, capsys, arguments, text):
    out = tmp_path / "out"
    assert main(["record", "--device", "twin", f"--out={out}", *arguments]) == 2
    assert text in capsys.readouterr().err
    assert not list(tmp_path.rglob("*.mcap"))
