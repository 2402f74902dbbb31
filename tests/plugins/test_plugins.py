"""Each kind of entry of an installed plug-in works in the commands, and passes its checks."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from installed import firstcontact, run

from firstcontact.recording import load_dataset

CHECKS = """
import sys
from firstcontact import plugins as p
p.check_policy(p.POLICIES["halfway"])
p.check_hand(p.HANDS["diary"])
p.check_source(p.SOURCES["reel"], "reel:" + sys.argv[1])
p.check_detector(p.DETECTORS["energy"])
p.check_estimator(p.ESTIMATORS["loudness"])
"""


@pytest.fixture(scope="session")
def recording(pinches: Path) -> Path:
    return sorted(pinches.rglob("*.mcap"))[0]


def test_live_drives_the_hand_with_the_policy_from_the_source(
    environment: dict[str, str], model: Path, recording: Path, tmp_path: Path
) -> None:
    diary = tmp_path / "diary"
    device = ("--device", f"reel:{recording}", "--speed", "inf", "--model", model)
    hand = ("--hand", "diary", "--hand-port", diary, "--policy", "halfway")
    process = firstcontact(environment, "live", *device, *hand, "--json")
    assert process.returncode == 0, process.stderr
    assert "hand diary with policy halfway" in process.stderr
    orders = diary.read_text(encoding="utf-8").splitlines()
    assert orders[0].startswith("close 0.13 ")
    assert orders[-1] == "release"


def test_what_is_exported_comes_back(
    environment: dict[str, str], recording: Path, tmp_path: Path
) -> None:
    out, back = tmp_path / "a.toy", tmp_path / "back"
    process = firstcontact(environment, "export", recording, "--to", "toy", "--out", out)
    assert process.returncode == 0, process.stderr
    process = firstcontact(environment, "import", out, "--out", back)
    assert process.returncode == 0, process.stderr
    assert len(load_dataset(back)) == len(load_dataset(recording))


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


def test_an_outsider_can_run_the_conformance_suites(
    environment: dict[str, str], recording: Path
) -> None:
    process = run(environment, CHECKS, recording)
    assert process.returncode == 0, process.stderr
