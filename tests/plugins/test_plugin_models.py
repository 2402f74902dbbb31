"""Detector and estimator of another package: training, saving, study and live use."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from installed import firstcontact, run

#: Contacts, scores and times alone: tests/lab has the other parts and the CNN.
STUDY = """
import sys
from dataclasses import replace
from pathlib import Path
from firstcontact.models import _cnn, _log_spectrum, _svm
from firstcontact_lab.study.run import run_study
from firstcontact_lab.study.part import StudySettings
small = replace(
    StudySettings(), block_pinches=20, object_pinches=4, durations=(0.015,), folds=3, brief=True,
    calls=20, detector="energy", workers=1, parts=("contacts", "objects", "inference"),
)
_cnn.Cnn.modules = ("not_installed",)
_svm.C_GRID, _svm.GAMMA_GRID, _svm.EPSILON_GRID = (10.0,), (0.3,), (0.15,)
_log_spectrum.C_GRID = (1.0,)
run_study(small, Path(sys.argv[1]), Path(sys.argv[2]), True, "none")
"""
CHECKS = """
from firstcontact.contact import DETECTORS
from firstcontact.models import ESTIMATORS
from firstcontact.testing import check_detector, check_estimator
check_detector(DETECTORS["energy"])
check_estimator(ESTIMATORS["loudness"])
"""


def test_a_kept_model_is_evaluated_and_live(
    model: Path, pinches: Path, environment: dict[str, str]
) -> None:
    process = firstcontact(environment, "evaluate", model, pinches, "--contacts", "detected")
    assert process.returncode == 0, process.stderr
    assert "contacts detected (energy;" in process.stdout
    recording = sorted(pinches.rglob("*.mcap"))[0]
    device = ("--device", recording, "--speed", "inf", "--model", model, "--json")
    process = firstcontact(environment, "live", *device)
    assert process.returncode == 0, process.stderr
    assert any(json.loads(line).get("value") is not None for line in process.stdout.splitlines())


@pytest.mark.slow  # tests/lab has the study; the two keep the promises of all, see below
def test_a_study_scores_and_draws_them(
    pinches: Path, environment: dict[str, str], tmp_path: Path
) -> None:
    process = run(environment, STUDY, tmp_path / "out", pinches)
    assert process.returncode == 0, process.stderr
    results = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    assert results["contact"]["windows_start_at"] == "energy"
    assert results["contact"]["energy"]["n"] == results["contact"]["svm"]["n"]
    assert results["objects"]["loudness"]["rmse"] > 0
    assert results["inference_us"]["loudness"]["p50"] > 0
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "Loudness alone" in page
    objects = page.partition('<section id="objects"')[2].partition("</section>")[0]
    assert "Loudness alone" in objects
    assert "energy" in page


def test_an_outsider_can_run_the_conformance_suites(environment: dict[str, str]) -> None:
    process = run(environment, CHECKS)
    assert process.returncode == 0, process.stderr
