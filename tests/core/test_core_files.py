"""Files and folders are written completely or not at all, even if the writer is killed."""

import os
import signal
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from firstcontact.core import InputError
from firstcontact.core.files import (
    creating,
    displaced_folder,
    files_below,
    given_path,
    open_regular,
    read_regular,
    replacing,
    replacing_folder,
    write_json,
    write_text,
)

#: Begins to write a file, says so, and waits for a line or for its end.
WRITER = """
import sys
from pathlib import Path
from firstcontact.core.files import {how}
with {how}(Path(sys.argv[1])) as temporary:
    temporary.write_text("from the child")
    print("begun", flush=True)
    sys.stdin.readline()
"""
#: Writes a folder and kills itself before, or after, its nth rename.
KILLED = """
import os, signal, sys
from pathlib import Path
from firstcontact.core.files import replacing_folder

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


def names(folder):
    return sorted(p.name for p in folder.iterdir())


def writer(path, how="replacing"):
    child = subprocess.Popen(
        [sys.executable, "-c", WRITER.format(how=how), str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert child.stdout.readline() == "begun\n"
    return child


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_failure_keeps_only_the_old_file(tmp_path, error):
    path = tmp_path / "new" / "results.json"
    write_text(path, "old")

    def fail():
        with replacing(path) as temporary:
            temporary.write_text("half", encoding="utf-8")
            raise error

    with pytest.raises(error):
        fail()
    with pytest.raises(ValueError, match="JSON"):
        write_json(path, {"rmse": float("nan")})
    assert path.read_text(encoding="utf-8") == "old"
    assert names(path.parent) == [path.name]


def test_next_writer_removes_the_files_of_a_killed_one(tmp_path):
    path = tmp_path / "results.json"
    with writer(path) as child:
        child.kill()
    (leftover,) = tmp_path.iterdir()
    assert not files_below(tmp_path, ".json")
    write_text(tmp_path / "other.json", "nothing to do with it")
    assert leftover.exists()
    write_text(path, "whole")
    assert names(tmp_path) == ["other.json", "results.json"]


def test_files_of_a_running_writer_stay(tmp_path):
    path = tmp_path / "results.json"
    with writer(path) as child:
        write_text(path, "from here")
        assert len(names(tmp_path)) == 2
        child.communicate("go on\n")
    assert child.returncode == 0
    assert path.read_text() == "from the child"
    assert names(tmp_path) == ["results.json"]


def test_creating_never_replaces_a_file(tmp_path):
    path = tmp_path / "o.csv"

    def create():
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


def test_first_of_two_creators_to_finish_wins(tmp_path):
    path = tmp_path / "o.csv"
    with writer(path, "creating") as child:
        with creating(path) as temporary:
            temporary.write_text("from here")
        child.communicate("go on\n")
    assert child.returncode == 1
    assert path.read_text() == "from here"
    assert names(tmp_path) == ["o.csv"]


def test_read_accepts_only_small_regular_files(tmp_path):
    pipe, file = tmp_path / "pipe", tmp_path / "file"
    os.mkfifo(pipe)
    file.write_bytes(b"12345")
    assert read_regular(file, 5) == b"12345"
    with pytest.raises(InputError, match=r"\b4\b"):
        read_regular(file, 4)
    for irregular in (pipe, tmp_path):  # opening the pipe would wait for ever
        with pytest.raises(InputError):
            open_regular(irregular)
    with pytest.raises(FileNotFoundError):
        open_regular(tmp_path / "none")


def test_files_are_found_by_suffix(tmp_path):
    (tmp_path / "a" / "b.wav").mkdir(parents=True)
    (tmp_path / "circle").symlink_to(tmp_path)
    expected = [tmp_path / "a" / "b.wav" / "1.wav", tmp_path / "a" / "c.WAV", tmp_path / "d.wav"]
    for path in (*expected, tmp_path / "wav", tmp_path / "a" / "d.csv"):
        path.write_text("")
    assert files_below(tmp_path, ".wav") == expected


OLD = {"a": "old", "c": "old", "03ms/d": "old"}
NEW = {"a": "new", "b": "new"}


@pytest.fixture
def out(tmp_path):
    folder = tmp_path / "there" / "m"
    (folder / "03ms").mkdir(parents=True)
    for name in OLD:
        (folder / name).write_text("old")
    return folder


def content(folder):
    return {str(p.relative_to(folder)): p.read_text() for p in folder.rglob("*") if p.is_file()}


def write_folder(out):
    with replacing_folder(out) as new:
        for name in NEW:
            (new / name).write_text("new")


def test_old_folder_is_replaced_completely(out, tmp_path):
    out.chmod(0o750)
    link = tmp_path / "link"
    link.symlink_to(out)
    write_folder(link)
    assert link.is_symlink()
    assert content(out) == NEW
    assert stat.S_IMODE(out.stat().st_mode) == 0o750
    assert names(out.parent) == ["m"]


@pytest.mark.parametrize("exists", [True, False])
def test_missing_or_empty_folder_is_replaced(tmp_path, exists):
    out = tmp_path / "a" / "b"
    if exists:
        out.mkdir(parents=True)
    write_folder(out)
    assert content(out) == NEW
    assert names(out.parent) == ["b"]


@pytest.mark.parametrize("error", [InputError("no"), KeyboardInterrupt(), OSError(28, "full")])
def test_error_restores_the_old_folder(out, error):
    def fail():
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
def test_kill_at_any_rename_leaves_the_old_or_the_new_folder(out, at, when):
    result = subprocess.run([sys.executable, "-c", KILLED, str(out), str(at), when])
    assert result.returncode == -signal.SIGKILL
    aside = displaced_folder(out)
    if out.exists():
        assert aside is None
        assert content(out) == (NEW if (at, when) == (3, "after") else OLD)
    else:
        assert aside is not None
        assert content(aside) == OLD
    # The next writer begins with the folder as it was, and leaves nothing else.
    with replacing_folder(out) as new:
        assert content(out) == (NEW if (at, when) == (3, "after") else OLD)
        (new / "a").touch()
    write_folder(out)
    assert content(out) == NEW
    assert names(out.parent) == ["m"]


def test_files_and_working_folders_are_refused(out, tmp_path, monkeypatch):
    file = tmp_path / "file"
    file.touch()
    monkeypatch.chdir(out / "03ms")
    for place in (file, Path("/"), out, Path(), Path("..")):
        with pytest.raises(InputError):
            write_folder(place)
    assert content(out) == OLD


def taken_meanwhile(new, out):
    """Write a folder, and a file in the place that it shall have."""
    write_text(new / "model.json", "made")
    out.write_text("of another program")


def test_content_is_kept_if_the_last_rename_is_refused(tmp_path):
    out = tmp_path / "model"
    with pytest.raises(InputError) as refused, replacing_folder(out) as new:
        taken_meanwhile(new, out)
    (kept,) = tmp_path.glob("model-*/model.json")
    assert kept.read_text() == "made"
    assert str(out) in str(refused.value)
    assert str(kept.parent) in str(refused.value)


@pytest.mark.parametrize("path", ["a" * 5000, "a/" * 3000, "\ud800"])
def test_paths_that_no_disk_has_are_refused(path):
    with pytest.raises(InputError) as refused:
        given_path(path)
    assert refused.value.parameter == "path"
    assert len(str(refused.value)) < 200


def test_a_user_without_a_home_is_asked_for_one():
    code = "from firstcontact.core.files import cache_path; cache_path('x')"
    nobody = f"import os, pwd; pwd.getpwuid = lambda n: pwd.getpwnam('no one'); {code}"
    run = subprocess.run(
        [sys.executable, "-c", nobody], env={}, capture_output=True, text=True, check=False
    )
    assert "FileError" in run.stderr
    assert "XDG_CACHE_HOME" in run.stderr
