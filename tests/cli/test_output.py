"""Terminal output is plain text, and a closed reader does not stop the work."""

import io
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.cli.main import main
from firstcontact.cli.output import Output
from firstcontact.core import Block, Label, fingertip_layout
from firstcontact.core.text import one_line, sanitize
from firstcontact.recording import Header, Marker, PinchMark, RecordingWriter

COMMAND = [sys.executable, "-m", "firstcontact.cli.main"]
#: Colours, a title, a cursor that goes up, 8-bit controls, text that runs backwards.
HOSTILE = "a\x1b[31m\x1b]0;owned\x07\x1b[2A\x9b31mb\u202ec\x7f\x08"


def is_plain(text: str) -> bool:
    """Return True if a terminal shows the text without control characters."""
    return all(
        c in "\n\t" or (c >= " " and not "\x7f" <= c <= "\x9f" and c not in "\u202e\u2028")
        for c in text
    )


@given(st.text())
def test_nothing_but_text_is_left_and_text_stays(text: str) -> None:
    assert is_plain(sanitize(text))
    assert sanitize(sanitize(text)) == sanitize(text)
    assert "\n" not in one_line(text)
    sanitize(text).encode()  # no halves of characters either


def test_a_progress_bar_goes_back_and_a_name_does_not() -> None:
    stream = io.StringIO()
    out = Output(stream)
    print("\rhalf", end="", file=out)
    print("\nname\rgood", file=out)
    assert stream.getvalue() == "\rhalf\nname\\u000dgood\n"


@pytest.fixture
def hostile(tmp_path: Path) -> Path:
    """Write a recording whose text fields all contain control characters."""
    path = tmp_path / f"{HOSTILE}.mcap"
    header = Header(
        layout=fingertip_layout(), source="synthetic", sensor=HOSTILE, hand=HOSTILE,
        firmware=HOSTILE, session=HOSTILE, notes=f"{HOSTILE}\n{HOSTILE}",
    )  # fmt: skip
    with RecordingWriter(path, header) as writer:
        writer.write(Block(np.zeros((500, 16), np.int16)))
        writer.marker(Marker(3, HOSTILE))
        writer.mark(
            PinchMark(0, 10, 400, 0, Label(HOSTILE, 10.0, specimen=HOSTILE, session=HOSTILE))
        )
    return path


def test_what_a_recording_says_of_itself_moves_no_cursor(
    hostile: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", str(hostile)]) == 0
    output = capsys.readouterr().out
    assert is_plain(output)
    assert output.count("a\\u001b[31m\\u001b]0;owned\\u0007\\u001b[2A\\u009b31mb\\u202ec") >= 8


def without_reader(stream: int) -> None:
    read, write = os.pipe()
    os.dup2(write, stream)
    os.close(read)
    os.close(write)


def closed(stream: int) -> None:
    os.close(stream)


def hung_up(stream: int) -> None:
    """Replace a stream by a closed terminal."""
    device, host = os.openpty()
    os.dup2(host, stream)
    os.close(host)
    os.close(device)


@pytest.mark.parametrize("lost", [without_reader, closed, hung_up])
def test_work_goes_on_to_its_end_when_nobody_reads(
    lost: Callable[[int], None], hostile: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out.csv"
    source = tmp_path / "in.mcap"
    hostile.rename(source)
    process = subprocess.run(
        [*COMMAND, "export", str(source), "--to", "csv", "--out", str(out)],
        stderr=subprocess.PIPE,
        preexec_fn=lambda: lost(1),
    )
    assert (process.returncode, process.stderr) == (0, b"")
    assert len(out.read_text(encoding="utf-8").splitlines()) > 300
    assert not list(tmp_path.glob(".*"))


def test_what_could_not_be_kept_is_no_success(hostile: Path) -> None:
    with Path("/dev/full").open("w") as full:
        process = subprocess.run(
            [*COMMAND, "inspect", hostile], stdout=full, stderr=subprocess.PIPE
        )
    assert process.returncode == 2
    assert b"standard output: No space left on device" in process.stderr
