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
