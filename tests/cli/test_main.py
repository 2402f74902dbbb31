"""The command: errors are one sentence and an exit code, for every verb."""

import subprocess
import sys
from dataclasses import dataclass
from typing import ClassVar

import pytest

from firstcontact.cli import main as command
from firstcontact.cli.verbs import configuration, summary, verb_places
from firstcontact.core import InputError


@dataclass(frozen=True)
class Raising:
    """Verb that raises an error."""

    error: ClassVar[BaseException]

    def run(self) -> None:
        """Raise the error."""
        raise self.error


def run(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> int:
    """Run main with a verb that raises this error."""
    monkeypatch.setattr(Raising, "error", error, raising=False)
    monkeypatch.setattr("firstcontact_lab.verbs.study.Study", Raising)
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


@pytest.mark.parametrize("verb", verb_places())
def test_every_verb_has_help(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        command.main([verb, "--help"])
    assert exit_.value.code == 0
    assert f"firstcontact {verb}" in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [["juggle"], ["--juggle"], []])
def test_no_verb_is_exit_2_and_says_which_there_are(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert command.main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert all(verb in err for verb in (*arguments, *verb_places()))


@pytest.mark.parametrize("option", ["--help", "-h"])
def test_the_overview_names_every_verb_with_its_own_words(
    option: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    assert command.main([option]) == 0
    out = capsys.readouterr().out
    for verb in verb_places():
        assert f"  {verb} " in out
        assert summary(verb) in out
        words = configuration(verb).__doc__
        assert words.split("\n\n")[0].replace("\n    ", " ") == summary(verb)


def loaded(*arguments: str) -> set[str]:
    """Return the modules that a command has imported when it ends."""
    code = (
        "import sys\n"
        "from firstcontact.cli.main import main\n"
        "try:\n"
        f"    main({list(arguments)!r})\n"
        "except SystemExit:\n"
        "    pass\n"
        "print(*sys.modules, file=sys.stderr)\n"
    )
    process = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    return set(process.stderr.split())


def test_the_overview_imports_next_to_nothing() -> None:
    modules = loaded("--help")
    assert not modules & {"numpy", "argparse", "scipy", "msgspec", "json"}
    ours = {name for name in modules if name.startswith("firstcontact.")}
    assert not ours - {
        "firstcontact.cli", "firstcontact.cli.main", "firstcontact.cli.output",
        "firstcontact.cli.stopping", "firstcontact.cli.verbs", "firstcontact.core",
        "firstcontact.core._errors", "firstcontact.core.text",
    }  # fmt: skip


@pytest.mark.parametrize("verb", ["live", "record", "import", "train", "study"])
def test_the_help_of_a_verb_imports_that_verb_and_no_arrays(verb: str) -> None:
    modules = loaded(verb, "--help")
    assert configuration(verb).__module__ in modules
    assert not modules & {"numpy", "scipy", "sklearn", "mcap", "msgspec", "h5py", "torch"}
    verbs = {configuration(other).__module__ for other in verb_places()} & modules
    assert verbs <= {configuration(verb).__module__, "firstcontact.cli.verbs.train"}
