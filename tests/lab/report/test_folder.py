"""Folder of a study: locked while the study runs, never overwritten by another study."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from firstcontact.core import InputError
from firstcontact.core.files import write_json
from firstcontact_lab.report.run import MARK, empty_marked_folder, locked_study_folder

ASKED = {"verb": "study", "recordings": None, "seed": 0, "durations": (0.003, 0.015)}
HOLD = """
import signal, sys
from pathlib import Path
from firstcontact_lab.report.run import locked_study_folder
with locked_study_folder(Path(sys.argv[1]), {}):
    print("held", flush=True)
    signal.pause()
"""


def claim(out: Path, requests: dict[str, object]) -> None:
    with locked_study_folder(out, requests):
        pass


def write(out: Path, requests: dict[str, object]) -> None:
    write_json(out / "results.json", {"study": {"asked": requests, "seed": 1}, "data": {}})


def test_a_second_study_is_refused_while_the_first_works(tmp_path: Path) -> None:
    out = tmp_path / "new" / "out"
    with subprocess.Popen([sys.executable, "-c", HOLD, out], stdout=subprocess.PIPE) as other:
        try:
            assert other.stdout.readline() == b"held\n"
            with pytest.raises(InputError, match="running"), locked_study_folder(out, {}):
                pass
            with locked_study_folder(tmp_path / "elsewhere", {}):
                pass
        finally:
            os.kill(other.pid, signal.SIGKILL)
    with locked_study_folder(out, {}):  # a dead process holds nothing
        assert list(out.iterdir()) == []
    with locked_study_folder(out, {}):
        pass


def test_a_refused_study_leaves_no_folder(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    for name in ("new", "there"):
        with (
            pytest.raises(InputError, match="no pinches"),
            locked_study_folder(tmp_path / name, {}),
        ):
            raise InputError("no pinches")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["there"]


def test_the_same_study_replaces_its_outputs(tmp_path: Path) -> None:
    claim(tmp_path, ASKED)
    write(tmp_path, ASKED)
    (tmp_path / "report.html").write_text("", encoding="utf-8")
    claim(tmp_path, ASKED)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"seed": 1}, "seed"),
        ({"durations": (0.003,)}, "durations"),
        ({"recordings": "/a"}, "recordings"),
        ({"verb": "grasp-study"}, "verb"),
        ({"more": 1}, "more"),
    ],
)
def test_another_study_is_refused(tmp_path: Path, change: dict[str, object], text: str) -> None:
    write(tmp_path, ASKED)
    original = (tmp_path / "results.json").read_bytes()
    with pytest.raises(InputError, match=rf"another study.* \(other {text}\)"):
        claim(tmp_path, {**ASKED, **change})
    assert (tmp_path / "results.json").read_bytes() == original


@pytest.mark.parametrize("text", ["", "{}", "[]", '{"study": {}}', '{"study": {"asked": 3}}'])
def test_results_that_nobody_knows_are_left_alone(tmp_path: Path, text: str) -> None:
    (tmp_path / "results.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=r"results\.json was not made"):
        claim(tmp_path, ASKED)


def test_so_is_a_report_and_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match=r"report\.html was not made"):
        claim(tmp_path, ASKED)
    os.mkfifo(tmp_path / "results.json")
    with pytest.raises(InputError, match=r"results\.json was not made"):
        claim(tmp_path, ASKED)


def test_only_what_a_study_made_is_removed(tmp_path: Path) -> None:
    mine = tmp_path / "recordings"
    (mine / "deep").mkdir(parents=True)
    with pytest.raises(InputError, match=f"{re.escape(str(mine))} was not made"):
        empty_marked_folder(mine, {})
    assert (mine / "deep").exists()
    made = empty_marked_folder(tmp_path / "made", {"a": 1})
    (made / "old").touch()
    assert [p.name for p in empty_marked_folder(made, {"a": 2}).iterdir()] == [MARK]
