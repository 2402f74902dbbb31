"""Matching of the rows of a table to the files of a folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path, PurePath

import pytest

from firstcontact.core import InputError
from firstcontact.recording._event_table import Columns
from firstcontact.recording._events import _files
from firstcontact.recording._file_rows import files_of_rows


@pytest.fixture
def names(tmp_path: Path) -> list[str]:
    names = [f"{k:02}.wav" for k in reversed(range(40))]
    for name in names:
        (tmp_path / name).touch()
    return names


def test_files_have_the_order_of_the_rows(tmp_path: Path, names: list[str]) -> None:
    assert files_of_rows(tmp_path, names, Path("t"), ".wav") == [tmp_path / n for n in names]
    rows = [names[k] for k in (3, 1, 3, 0)]
    files, numbers, _ = _files(tmp_path, Path("t"), Columns({"file": rows}, range(4)))
    assert [files[k].name for k in numbers if k is not None] == rows
    assert len(files) == 3


def test_blanks_around_names_are_ignored(tmp_path: Path, names: list[str]) -> None:
    padded = [f" {name}\t" for name in names]
    files = files_of_rows(tmp_path, padded, Path("t"), ".wav")
    assert files == _files(tmp_path, Path("t"), Columns({"file": padded}, range(40)))[0]


@pytest.mark.parametrize("change", [lambda n: n[1:], lambda n: [*n, n[0]], lambda n: [*n, "x.wav"]])
def test_rows_that_do_not_match_are_refused(
    tmp_path: Path, names: list[str], change: Callable[[list[str]], list[str]]
) -> None:
    with pytest.raises(InputError, match=r"t: .*\.wav"):
        files_of_rows(tmp_path, change(names), Path("t"), ".wav")


def test_files_are_compared_few_times(
    tmp_path: Path, names: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    comparisons = 0
    compare = PurePath.__eq__

    def counted(path: PurePath, other: object) -> bool:
        nonlocal comparisons
        comparisons += 1
        return compare(path, other)

    monkeypatch.setattr(PurePath, "__eq__", counted)
    files_of_rows(tmp_path, names, Path("t"), ".wav")
    _files(tmp_path, Path("t"), Columns({"file": names}, range(40)))
    assert comparisons <= 3 * len(names)
