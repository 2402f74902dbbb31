"""Folders are replaced completely or not at all if the writer is killed."""

from __future__ import annotations

import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from firstcontact.core import InputError, displaced_folder, replacing_folder

#: Writes a folder and kills itself before, or after, its nth rename.
KILLED = """
import os, signal, sys
from pathlib import Path
from firstcontact.core._folders import replacing_folder

out, at, before = Path(sys.argv[1]), int(sys.argv[2]), sys.argv[3] == "before"
rename, count = Path.rename, 0

def deadly(self, target):
    global count
    count += 1
    if count == at and before:
        os.kill(os.getpid(), signal.SIGKILL)
    try:
        return rename(self, target)
    finally:
        if count == at:
            os.kill(os.getpid(), signal.SIGKILL)

Path.rename = deadly
with replacing_folder(out) as new:
    for name in ("a", "b"):
        (new / name).write_text("new")
"""


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def content(folder: Path) -> dict[str, str]:
    return {str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture
def out(tmp_path: Path) -> Path:
    folder = tmp_path / "there" / "m"
    (folder / "03ms").mkdir(parents=True)
    for name in ("a", "c", "03ms/d"):
        (folder / name).write_text("old")
    return folder


OLD = {"a": "old", "c": "old", "03ms/d": "old"}
NEW = {"a": "new", "b": "new"}


def write(out: Path) -> None:
    with replacing_folder(out) as new:
        for name in NEW:
            (new / name).write_text("new")


def test_old_folder_is_replaced_completely(out: Path) -> None:
    out.chmod(0o750)
    write(out)
    assert content(out) == NEW
    assert stat.S_IMODE(out.stat().st_mode) == 0o750
    assert names(out.parent) == ["m"]


@pytest.mark.parametrize("exists", [True, False])
def test_missing_or_empty_folder_is_replaced(tmp_path: Path, exists: bool) -> None:
    out = tmp_path / "a" / "b"
    if exists:
        out.mkdir(parents=True)
    write(out)
    assert content(out) == NEW
    assert names(out.parent) == ["b"]


def test_a_link_is_followed(out: Path, tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(out)
    write(link)
    assert link.is_symlink()
    assert content(out) == NEW


@pytest.mark.parametrize("error", [InputError("no"), KeyboardInterrupt(), OSError(28, "full")])
def test_error_restores_the_old_folder(out: Path, error: BaseException) -> None:
    def fail() -> None:
        with replacing_folder(out) as new:
            (new / "a").write_text("new")
            raise error

    with pytest.raises(type(error)) as caught:
        fail()
    if isinstance(error, OSError):
        assert caught.value.filename == str(out)  # a full disk names no file
    assert content(out) == OLD
    assert names(out.parent) == ["m"]


@pytest.mark.parametrize("when", ["before", "after"])
@pytest.mark.parametrize("at", [1, 2, 3])
def test_kill_at_any_rename_leaves_the_old_or_the_new_folder(out: Path, at: int, when: str) -> None:
    result = subprocess.run([sys.executable, "-c", KILLED, str(out), str(at), when])
    assert result.returncode == -signal.SIGKILL
    aside = displaced_folder(out)
    if out.exists():
        assert aside is None
        assert content(out) == (NEW if (at, when) == (3, "after") else OLD)
    else:
        assert aside is not None
        assert content(aside) == OLD
    # The next one begins with what was there, and leaves nothing else.
    with replacing_folder(out) as new:
        assert content(out) == (NEW if (at, when) == (3, "after") else OLD)
        (new / "a").touch()
    write(out)
    assert content(out) == NEW
    assert names(out.parent) == ["m"]


def test_second_writer_is_refused(out: Path) -> None:
    with replacing_folder(out) as new:
        (new / "a").write_text("first")
        with pytest.raises(InputError, match=out.name):
            write(out)
        assert content(out) == OLD
    assert content(out) == {"a": "first"}


@pytest.mark.parametrize("name", ["m.x", "x.m", "M"])
def test_folders_of_similar_names_have_separate_locks(out: Path, name: str) -> None:
    with replacing_folder(out.with_name(name)):
        write(out)
    assert names(out.parent) == sorted(["m", name])


def test_files_and_working_folders_are_refused(
    out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.touch()
    with pytest.raises(InputError, match=file.name):
        write(file)
    with pytest.raises(InputError):
        write(Path("/"))
    monkeypatch.chdir(out / "03ms")
    for place in (out, Path(), Path("..")):
        with pytest.raises(InputError):
            write(place)
    assert content(out) == OLD
