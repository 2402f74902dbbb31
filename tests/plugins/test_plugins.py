"""An installed plug-in extends every command. Its broken entries affect nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest
from installed import firstcontact, run

from firstcontact.recording import load_dataset

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
def recording(pinches: Path) -> Path:
    return sorted(pinches.rglob("*.mcap"))[0]


@pytest.mark.parametrize(
    ("verb", "words"),
    [
        ("live", ["halfway", "diary", "tape:", "broken"]),
        ("train", ["loudness", "energy"]),
        ("export", ["toy"]),
    ],
)
def test_help_lists_them_unseen(verb: str, words: list[str], environment: dict[str, str]) -> None:
    process = firstcontact(environment, verb, "--help")
    assert process.returncode == 0, process.stderr
    for word in words:
        assert word in process.stdout
    assert process.stderr == ""


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


def test_an_outsider_can_run_the_conformance_suites(
    environment: dict[str, str], recording: Path
) -> None:
    process = run(environment, CHECKS, recording)
    assert process.returncode == 0, process.stderr
