"""What the parser of options refuses is one sentence with exit code 2, like everything else."""

from __future__ import annotations

import pytest

from firstcontact.cli.main import main
from firstcontact.cli.refusals import in_one_sentence


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["simulate", "--out", "x", "--condition", "lab"], ("'lab'", "--condition", "everyday")),
        (["simulate"], ("--out PATH",)),
        (["simulate", "--out", "x", "--seed", "a"], ("--seed", "'a'")),
        (["simulate", "--out", "x", "--seed", "1_0"], ("--seed", "'1_0'")),
        (["train", "x", "--out", "y", "--window-ms", "１５"], ("--window-ms",)),
        (["simulate", "--out", "x", "--sed", "3"], ("--sed", "perhaps you meant --seed INT")),
        (["simulate", "--out"], ("--out",)),
        (["train", "x", "--out", "y", "--window-ms", "a"], ("--window-ms", "'a'")),
    ],
)
def test_an_option_that_cannot_be_is_one_sentence(
    arguments: list[str], words: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    assert said.err.startswith("firstcontact: ")
    assert f"all options: `firstcontact {arguments[0]} --help`" in said.err
    assert not set("│─╭╰|+") & set(said.err)
    assert "---" not in said.err
    for word in words:
        assert word in said.err


def test_help_still_goes_to_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["simulate", "--help"])
    assert not end.value.code
    assert "--condition" in capsys.readouterr().out


def test_what_is_no_box_is_said_as_it_is() -> None:
    assert in_one_sentence("error: no such option\n") == "error: no such option"
    assert in_one_sentence("") == ""
