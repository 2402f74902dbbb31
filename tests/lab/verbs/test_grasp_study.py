"""Refusals of ``firstcontact grasp-study``. ``.ci/run`` runs the quick study."""

from pathlib import Path

import pytest

from firstcontact.cli.main import main


@pytest.mark.parametrize(("option", "value"), [("--seed", "-1"), ("--workers", "100000")])
def test_numbers_that_make_no_sense_are_refused(
    option: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["grasp-study", option, value, "--out", str(tmp_path / "x")]) == 2
    assert option in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
