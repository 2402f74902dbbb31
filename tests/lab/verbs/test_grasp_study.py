"""``firstcontact grasp-study``: from the twin to the report, and its refusals."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from firstcontact.cli.main import main
from firstcontact_lab.grasping.run import GraspStudySettings


@pytest.fixture
def smallest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reduce the quick study further. `.ci/run` runs it in its normal size."""
    small = GraspStudySettings(
        tuning_hands=1,
        judged_hands=1,
        tuning_specimens=(1,),
        judged_specimens=(2,),
        blocks=4,
        speeds=(0.10,),
        boosts=(2.0,),
        forces=(1.0, 3.0, 12.0),
        folds=2,
        budget=2,
        few=True,
        permutations=1,
        kinds=("raspberry", "apple", "wrench"),
    )
    monkeypatch.setattr(
        GraspStudySettings,
        "quick",
        lambda self: replace(small, seed=self.seed, workers=self.workers),
    )


@pytest.mark.slow  # `make quick-grasp` runs in .ci/run; tests/lab/grasping has each part
@pytest.mark.usefixtures("smallest")
def test_quick_runs_from_end_to_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "study"
    assert main(["grasp-study", "--quick", "--out", str(out), "--seed", "5", "--workers", "1"]) == 0
    assert capsys.readouterr().out.strip() == str(out / "report.html")
    results = json.loads((out / "results.json").read_text(encoding="utf-8"))
    assert results["study"]["quick"]
    household = results["household"]
    picks = household["objects"] * household["hands"]
    assert household["picks"] == picks
    assert all(closings["n"] == picks for closings in household["closings"].values())
    assert not set(household["tuned_on"]["hands"]) & set(household["judged_on"]["hands"])
    assert (out / "grasp.png").stat().st_size > 1000
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Quick study" in page


@pytest.mark.parametrize(("option", "value"), [("--seed", "-1"), ("--workers", "100000")])
def test_numbers_that_make_no_sense_are_refused(
    option: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["grasp-study", option, value, "--out", str(tmp_path / "x")]) == 2
    assert option in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
