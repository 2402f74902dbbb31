"""Completion by the Tab key offers the options that the help lists."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from firstcontact.cli import main as command
from firstcontact.cli.verbs import verb_places


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("completion") / "firstcontact"
    with path.open("w") as file, pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.stdout", file)
        assert command.main(["--completion"]) == 0
    return path


def completed(script: Path, *words: str) -> set[str]:
    """Return the completions of bash for these words; the last one is incomplete."""
    code = (
        'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); '
        'complete -p firstcontact > /dev/null && _firstcontact; printf "%s\\n" "${COMPREPLY[@]}"'
    )
    process = subprocess.run(
        ["bash", "-uc", code, "bash", str(script), "firstcontact", *words],
        env={"PATH": ""},  # no Python is started
        executable=shutil.which("bash"),
        capture_output=True,
        text=True,
        check=True,
    )
    assert process.stderr == ""
    return set(process.stdout.split())


def test_verbs_are_completed(script: Path) -> None:
    assert completed(script, "") == {*verb_places(), "--help", "--version", "--completion"}
    assert completed(script, "st") == {"study"}


@pytest.mark.parametrize("verb", verb_places())
def test_each_option_in_the_help_of_a_verb_is_completed(
    verb: str, script: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        command.main([verb, "--help-all"])
    text = capsys.readouterr().out
    options = set(re.findall(r"^  (?:-h, )?(--[\w-]+)", text, re.MULTILINE))
    assert completed(script, verb, "--") == options | {"--verbose"}


def test_choices_and_files_are_completed(script: Path) -> None:
    assert completed(script, "simulate", "--condition", "") == {"paper-rig", "everyday"}
    assert completed(script, "train", "data", "--detector-type", "th") == {"three_sigma"}
    # Bash completes the names of files where the function offers nothing.
    assert completed(script, "inspect", "pinches/") == set()
    assert "complete -o default " in script.read_text()
