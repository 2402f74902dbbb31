"""An installed plug-in extends every command. Its broken entries affect nothing else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from installed import firstcontact, run

from firstcontact.recording import load_dataset
from shared_runs import made_once

#: Models, the payload task of all policies and the report; the household, whose policies have
#: another task, is made up.
STUDY = """
import sys
from pathlib import Path
from firstcontact.core import Serial
from firstcontact.models import _svm
from firstcontact_lab.grasping import run
from firstcontact_lab.grasping._learning import learn
from firstcontact_lab.grasping.chapters import render
from firstcontact_lab.grasping.settings import GraspStudySettings
from firstcontact_lab.report.results import write_results
sys.path.append(sys.argv[2])
from toy_results import results
out, kinds = Path(sys.argv[1]), ("block 5", "block 60", "egg shell")
small = GraspStudySettings(
    sessions=1, training=10, windows=(0.015,), tuning=1, coarse=True, kinds=kinds, workers=1
)
_svm.C_GRID, _svm.GAMMA_GRID, _svm.EPSILON_GRID = (10.0,), (0.3,), (0.15,)
study = results(run._payload(small, learn(small, out), Serial()))
write_results(out / "results.json", study)
(out / "film.gif").write_bytes(b"GIF89a")
(out / "report.html").write_text(render(study, out / "film.gif"), encoding="utf-8")
"""
#: Made-up results of a grasp study.
TOYS = Path(__file__).parents[1] / "lab" / "grasping"
CHECKS = """
import sys
from firstcontact.device._opening import SOURCES
from firstcontact.grasp import HANDS, POLICIES
from firstcontact.testing import check_hand, check_policy, check_source
check_policy(POLICIES["halfway"])
check_hand(HANDS["diary"])
check_source(SOURCES["tape"], "tape:" + sys.argv[1])
"""


@pytest.fixture(scope="session")
def study(environment: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    def make(out: Path) -> None:
        process = run(environment, STUDY, out, TOYS)
        assert process.returncode == 0, process.stderr

    return made_once(tmp_path_factory, "plugin-grasp-study", make)


@pytest.fixture(scope="session")
def recording(pinches: Path) -> Path:
    return sorted(pinches.rglob("*.mcap"))[0]


@pytest.mark.parametrize(
    ("verb", "words"),
    [
        ("live", ["halfway", "diary", "tape:", "broken"]),
        ("record", ["tape:"]),
        ("info", ["tape:"]),
        ("import", ["toy"]),
        ("export", ["toy"]),
    ],
)
def test_help_lists_them_unseen(verb: str, words: list[str], environment: dict[str, str]) -> None:
    process = firstcontact(environment, verb, "--help")
    assert process.returncode == 0, process.stderr
    for word in words:
        assert word in process.stdout
    assert process.stderr == ""


@pytest.mark.slow  # the policy keeps the promises of all and drives a hand, see below
def test_a_policy_is_closed_with_judged_and_drawn(study: Path) -> None:
    results = json.loads((study / "results.json").read_text(encoding="utf-8"))["payload"]
    ours, touch = (results["policies"][name]["20"]["all"] for name in ("halfway", "touch"))
    assert ours["n"] == touch["n"] == 3
    assert ours["peak_n"] > touch["peak_n"]
    assert list(results["policies"])[-1] == "halfway"
    page = (study / "report.html").read_text(encoding="utf-8")
    assert "half as gentle" in page
    assert "broken" not in results["policies"]


def test_live_drives_the_hand_with_the_policy_from_the_source(
    environment: dict[str, str], model: Path, recording: Path, tmp_path: Path
) -> None:
    diary = tmp_path / "diary"
    device = ("--device", f"tape:{recording}", "--speed", "inf", "--model", model)
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


@pytest.mark.parametrize(
    "arguments",
    [
        ("live", "--device", "twin", "--hand", "broken"),
        ("live", "--device", "broken:1"),
        ("export", "RECORDING", "--to", "broken", "--out", "x"),
    ],
)
def test_what_is_broken_is_refused_with_its_reason(
    arguments: tuple[str, ...], environment: dict[str, str], recording: Path, tmp_path: Path
) -> None:
    predictions = [str(recording) if word == "RECORDING" else word for word in arguments]
    process = firstcontact({**environment, "XDG_CACHE_HOME": str(tmp_path)}, *predictions)
    assert process.returncode == 2, process.stderr
    text = process.stderr.splitlines()[-1]
    assert text.startswith("firstcontact: the plug-in 'broken'")
    assert "ImportError: libtoy is missing" in text


def test_a_broken_policy_is_refused_with_its_reason(
    environment: dict[str, str], model: Path, recording: Path
) -> None:
    device = ("--device", recording, "--speed", "inf", "--model", model)
    process = firstcontact(environment, "live", *device, "--hand", "print", "--policy", "broken")
    assert process.returncode == 2, process.stderr
    assert "ImportError: libtoy is missing" in process.stderr.splitlines()[-1]


def test_an_outsider_can_run_the_conformance_suites(
    environment: dict[str, str], recording: Path
) -> None:
    process = run(environment, CHECKS, recording)
    assert process.returncode == 0, process.stderr
