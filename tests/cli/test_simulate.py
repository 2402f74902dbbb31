from __future__ import annotations

from pathlib import Path

import pytest

from firstcontact.cli.main import main


def test_simulate_writes_recordings_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "set"
    assert (
        main(
            ["simulate", "--out", str(out), "--pinches-per-block", "1", "--pinches-per-object", "1"]
        )
        == 0
    )
    assert "13 pinches in 2 recordings" in capsys.readouterr().out
    assert sorted(p.name for p in out.iterdir()) == ["blocks-01.mcap", "objects-01.mcap"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--pinches-per-block", "-1"], "must be 0 or more"),
        (["--pinches-per-block", "0", "--pinches-per-object", "0"], "must be above 0"),
        (["--seed", "-3"], "seed is -3"),
        (["--workers", "-1"], "workers is -1"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], words: str
) -> None:
    assert main(["simulate", "--out", str(tmp_path / "set"), *options]) == 2
    message = capsys.readouterr().err.splitlines()[-1]
    assert message.startswith("firstcontact: ")
    assert words in message
    assert not (tmp_path / "set").exists()
