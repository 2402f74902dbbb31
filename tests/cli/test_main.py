"""The command: errors are one sentence and an exit code, for every verb."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import pytest

from firstcontact.cli import main as command
from firstcontact.core import InputError


@dataclass(frozen=True)
class Raising:
    """A verb that raises."""

    error: ClassVar[BaseException]

    def run(self) -> None:
        """Raise."""
        raise self.error


def run(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> int:
    """Run main with a verb that raises this."""
    monkeypatch.setattr(Raising, "error", error, raising=False)
    monkeypatch.setattr("firstcontact.cli.study.Study", Raising)
    return command.main(["study"])


def test_input_that_cannot_be_used_is_one_line_and_exit_2(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, InputError("labels.csv: shore_a is missing")) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err == "firstcontact: labels.csv: shore_a is missing\n"


def test_interrupted_is_exit_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(monkeypatch, KeyboardInterrupt()) == 130
    assert capsys.readouterr().err == "firstcontact: interrupted\n"


def test_a_closed_pipe_is_no_error(monkeypatch: pytest.MonkeyPatch) -> None:
    assert run(monkeypatch, BrokenPipeError()) == 0


def test_a_fault_of_ours_keeps_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ZeroDivisionError):
        run(monkeypatch, ZeroDivisionError())


@pytest.mark.parametrize("verb", command.VERBS)
def test_every_verb_has_help(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        command.main([verb, "--help"])
    assert exit_.value.code == 0
    assert f"firstcontact {verb}" in capsys.readouterr().out


def test_an_unknown_verb_is_exit_2(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        command.main(["juggle"])
    assert exit_.value.code == 2
    assert "juggle" in capsys.readouterr().err


def test_importing_the_verbs_imports_nothing_heavy() -> None:
    heavy = {"torch", "numba", "matplotlib", "pyarrow", "onnxruntime", "onnx", "h5py", "sklearn"}
    modules = [command._module(verb) for verb in command.VERBS]
    code = "\n".join(
        [
            "import sys",
            *(f"import firstcontact.cli.{module}" for module in modules),
            f"print(sorted({heavy!r} & set(sys.modules)))",
        ]
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "arguments",
    [
        ["inspect", "absent.mcap"],
        ["export", "absent", "--to", "csv", "--out", "out"],
        ["import", "absent", "--out", "out"],
        ["study", "--recordings", "absent", "--out", "out"],
    ],
    ids=lambda a: a[0],
)
def test_what_is_not_there_is_named(
    arguments: list[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert command.main(arguments) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line for line in lines if line.startswith("firstcontact: ")] == lines[-1:]
    assert "absent" in lines[-1]
    assert not any(path.is_file() for path in tmp_path.rglob("*"))


def test_a_path_that_cannot_be_is_one_sentence(tmp_path, capsys):
    file = tmp_path / "file"
    file.write_text("")
    out = str(file / "below")
    assert command.main(["simulate", "--out", out, "--pinches-per-block", "1"]) == 2
    said = capsys.readouterr().err.strip().splitlines()[-1]
    assert said.startswith("firstcontact: ")
    assert str(file) in said
