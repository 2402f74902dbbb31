"""Atomic files: each is complete or unchanged."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import pytest

from firstcontact.core import (
    InputError,
    files_below,
    open_regular,
    read_regular,
    replacing,
    resolve_path,
    write_json,
    write_text,
)


def names(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_write_creates_the_folder(tmp_path: Path) -> None:
    path = tmp_path / "new" / "Prüfling 1.json"
    write_json(path, {"shore_a": 28.0})
    assert json.loads(path.read_text(encoding="utf-8")) == {"shore_a": 28.0}
    assert names(path.parent) == [path.name]


def test_file_appears_only_when_complete(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    write_text(path, "old")
    with replacing(path) as temporary:
        temporary.write_text("new", encoding="utf-8")
        assert path.read_text(encoding="utf-8") == "old"
        assert temporary.stat().st_dev == path.stat().st_dev
        assert temporary.name == path.name
    assert path.read_text(encoding="utf-8") == "new"


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_failure_keeps_only_the_old_file(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "results.json"
    write_text(path, "old")

    def fail() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half", encoding="utf-8")
            raise error

    with pytest.raises(error):
        fail()
    assert path.read_text(encoding="utf-8") == "old"
    assert names(tmp_path) == [path.name]


def test_nan_is_not_json(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "results.json", {"rmse": float("nan")})
    assert names(tmp_path) == []


def test_two_writers_do_not_share_a_temporary_name(tmp_path: Path) -> None:
    path = tmp_path / "results.json"
    with replacing(path) as first_file, replacing(path) as second_file:
        assert first_file != second_file
        first_file.write_text("one", encoding="utf-8")
        second_file.write_text("other", encoding="utf-8")
    assert path.read_text(encoding="utf-8") == "one"
    assert names(tmp_path) == [path.name]


def test_read_accepts_only_small_regular_files(tmp_path: Path) -> None:
    pipe, file = tmp_path / "pipe", tmp_path / "file"
    os.mkfifo(pipe)
    file.write_bytes(b"12345")
    assert read_regular(file, 5) == b"12345"
    assert read_regular(file, 1 << 62) == b"12345"  # no memory is asked for that is not needed
    with pytest.raises(InputError, match=r"\b4\b"):
        read_regular(file, 4)
    for irregular in (pipe, tmp_path):  # opening the pipe would wait for ever
        with pytest.raises(InputError):
            open_regular(irregular)
    with pytest.raises(FileNotFoundError):
        open_regular(tmp_path / "none")


def test_link_loop_is_refused(tmp_path: Path) -> None:
    link = tmp_path / "link"
    link.symlink_to(link)
    if sys.version_info < (3, 13):  # later ones say where the circle begins
        with pytest.raises(InputError):
            resolve_path(link)
    assert resolve_path(tmp_path / "nothing") == (tmp_path / "nothing").resolve()


def test_files_are_found_by_suffix_up_to_a_limit(
    tmp_path: Path,
) -> None:
    (tmp_path / "a" / "b.wav").mkdir(parents=True)
    (tmp_path / "circle").symlink_to(tmp_path)
    expected = [tmp_path / "a" / "b.wav" / "1.wav", tmp_path / "a" / "c.WAV", tmp_path / "d.wav"]
    for path in (*expected, tmp_path / "wav", tmp_path / "a" / "d.csv"):
        path.write_text("")
    assert files_below(tmp_path, ".wav") == expected
    assert files_below(tmp_path, ".wav", most=8) == expected
    with pytest.raises(InputError, match="7"):
        files_below(tmp_path, ".wav", most=7)
