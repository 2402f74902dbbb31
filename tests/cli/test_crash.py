"""Unexpected errors: one sentence, a log, a separate exit code and no partial files."""

import errno
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from firstcontact import __version__
from firstcontact.cli import main as command
from firstcontact.core.files import replacing

#: Raises in the place of a verb, as no verb is known to do.
PROGRAM = """
import sys
from dataclasses import dataclass
from pathlib import Path
import firstcontact.cli.verbs.info as info
from firstcontact.cli.main import main
from firstcontact.core.files import replacing

@dataclass(frozen=True)
class Info:
    token: str = ""
    def run(self):
        with replacing(Path("out.json")) as temporary:
            temporary.write_text("half")
            {body}

info.Info = Info
sys.exit(main())
"""


def run(
    body: str, folder: Path, *arguments: str, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run the verb ``info`` with another function as its body, in a given folder."""
    (folder / "logs").mkdir()
    return subprocess.run(
        [sys.executable, "-c", PROGRAM.format(body=body), "info", *arguments],
        cwd=folder,
        env={**os.environ, "TMPDIR": str(folder / "logs"), **environment},
        capture_output=True,
        text=True,
    )


def only_log(folder: Path) -> Path:
    """Return the single file in a folder."""
    (log,) = folder.iterdir()
    return log


def test_a_fault_is_one_sentence_a_log_and_its_own_exit_code(tmp_path: Path) -> None:
    process = run('raise ZeroDivisionError("by 0\\\\n\\x1b[31m")', tmp_path, "--token=s3cret")
    assert process.returncode == 70
    assert process.stdout == ""
    (message,) = process.stderr.splitlines()
    log = only_log(tmp_path / "logs")
    assert message.startswith("firstcontact: ")
    assert "ZeroDivisionError: by 0\\n\\u001b[31m" in message
    assert "report" in message
    assert message.endswith(str(log))
    text = log.read_text(encoding="utf-8")
    assert f"firstcontact {__version__}" in text
    assert "Python 3." in text
    assert "Traceback (most recent call last)" in text
    assert "command: firstcontact info" in text
    assert "\x1b" not in text
    assert log.stat().st_mode & 0o077 == 0
    # What was being written is gone.
    assert [p.name for p in tmp_path.iterdir()] == ["logs"]


def test_the_log_has_the_last_lines_and_no_token(tmp_path: Path) -> None:
    logs = '__import__("logging").getLogger("firstcontact.x").info("device is lost")'
    process = run(
        f'{logs}; raise RuntimeError("with " + self.token)', tmp_path, "--token", "s3cret"
    )
    assert process.returncode == 70
    text = only_log(tmp_path / "logs").read_text(encoding="utf-8")
    assert "s3cret" not in text
    assert "device is lost" in text


@dataclass(frozen=True)
class Raising:
    """Verb that raises an error while it writes."""

    error: ClassVar[BaseException]
    out: ClassVar[Path]

    def run(self) -> None:
        """Raise the error."""
        with replacing(self.out) as temporary:
            temporary.write_text("half")
            raise self.error


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (OSError(errno.EIO, "Input/output error"), 70),
        (MemoryError(), 70),
        (RecursionError("too deep"), 70),
        (UnicodeDecodeError("utf-8", b"\xff", 0, 1, "no"), 70),
        (OSError(errno.ENOSPC, "No space left on device"), 2),
        (OSError(errno.EACCES, "Permission denied", "there"), 2),
    ],
    ids=lambda x: type(x).__name__,
)
def test_whatever_it_is_nothing_is_left_half_written(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    error: BaseException,
    code: int,
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(Raising, "error", error, raising=False)
    monkeypatch.setattr(Raising, "out", tmp_path / "out", raising=False)
    monkeypatch.setattr("firstcontact_lab.verbs.study.Study", Raising)
    assert command.main(["study"]) == code
    (errors,) = capsys.readouterr().err.splitlines()
    assert errors.startswith("firstcontact: ")
    assert len(list(tmp_path.iterdir())) == (code == 70)
