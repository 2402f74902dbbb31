"""Locks of temporary files: sweeping removes files of killed writers only."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from firstcontact.core import creating, is_temporary, replacing, temporary_path, write_text
from firstcontact.core._atomic import sweep

# Begins to write a file, says so, and waits to be told to go on or to be killed.
WRITER = """
import sys
from pathlib import Path
from firstcontact.core._files import {how}
with {how}(Path(sys.argv[1])) as temporary:
    temporary.write_text("from the child")
    print("begun", flush=True)
    sys.stdin.readline()
"""


def writer(path: Path, how: str = "replacing") -> subprocess.Popen[str]:
    child = subprocess.Popen(
        [sys.executable, "-c", WRITER.format(how=how), str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "begun\n"
    return child


def names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_next_writer_sweeps_the_files_of_a_killed_one(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    with writer(path) as child:
        child.kill()
    (leftover,) = tmp_path.iterdir()
    assert is_temporary(leftover / "results.json", tmp_path)
    write_text(tmp_path / "other.json", "nothing to do with it")
    assert leftover.exists()
    write_text(path, "whole")
    assert names(tmp_path) == ["other.json", "results.json"]


def test_files_of_a_running_writer_are_not_swept(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    with writer(path) as child:
        write_text(path, "from here")
        sweep(tmp_path)
        assert len(names(tmp_path)) == 2
        child.communicate("go on\n")
    assert child.returncode == 0
    assert path.read_text() == "from the child"
    assert names(tmp_path) == ["results.json"]


def test_only_leftovers_of_older_versions_are_swept(tmp_path: Path) -> None:
    other_names = [".o.12345678.part.txt", ".o.1234567.part", "o.12345678.part", ".p.12345678.part"]
    for name in (".o.12345678.part", *other_names):
        (tmp_path / name).touch()
    folder = tmp_path / ".o.abcdef01.part"
    folder.mkdir()
    (folder / "000.mcap").touch()
    (tmp_path / ".o.abcdef02.part").symlink_to(tmp_path)
    write_text(tmp_path / "o", "")
    assert names(tmp_path) == sorted([*other_names, "o", ".o.abcdef02.part"])
    sweep(tmp_path / "none")


def test_only_files_below_the_folder_are_temporary(tmp_path: Path) -> None:
    with temporary_path(tmp_path / "a.mcap") as inside:
        assert is_temporary(inside, tmp_path)
        assert not is_temporary(inside, inside.parent)
    assert not is_temporary(tmp_path / "session-1.part2.mcap", tmp_path)
    assert names(tmp_path) == []


def test_creating_never_replaces_a_file(tmp_path: Path) -> None:
    path = tmp_path / "o.csv"

    def create() -> None:
        with creating(path) as temporary:
            temporary.write_text("mine")

    create()
    with pytest.raises(FileExistsError):
        create()
    path.unlink()
    path.symlink_to(tmp_path / "nowhere")
    with pytest.raises(FileExistsError):
        create()
    assert names(tmp_path) == ["o.csv"]


def test_first_of_two_creators_to_finish_wins(tmp_path: Path) -> None:
    path = tmp_path / "o.csv"
    with writer(path, "creating") as child:
        with creating(path) as temporary:
            temporary.write_text("from here")
        child.communicate("go on\n")
    assert child.returncode == 1
    assert path.read_text() == "from here"
    assert names(tmp_path) == ["o.csv"]


def test_an_interrupted_replacement_leaves_nothing(tmp_path: Path) -> None:
    def interrupted() -> None:
        with replacing(tmp_path / "a") as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert names(tmp_path) == []
