"""A session goes on, whatever its recorder left when it was killed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.collect import so_far
from firstcontact.core import Block, InputError, Label, fingertip_layout
from firstcontact.device import Descriptor
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset

LAYOUT = fingertip_layout()
DESCRIPTOR = Descriptor(LAYOUT, source="twin")
LABEL = Label("block 20", 20.0, None, "block 20", "1")


def record(path: Path, label: Label = LABEL) -> Path:
    """A whole recording of one pinch."""
    with RecordingWriter(path, Header(LAYOUT, "twin", session="1")) as writer:
        writer.write(Block(np.zeros((2000, 16), np.int16)))
        writer.mark(PinchMark(0, 100, 900, 0, label))
    return path


def cut_to(path: Path, length: int) -> bytes:
    """The file as a writer leaves it that is killed, or has no disk left, after so many bytes."""
    data = record(path).read_bytes()[:length]
    path.write_bytes(data)
    return data


@pytest.mark.parametrize("length", [0, 41, 4096, 8192])
def test_collecting_goes_on_behind_a_part_that_cannot_be_read(tmp_path: Path, length: int) -> None:
    first = tmp_path / "session-1.mcap"
    left = cut_to(first, length)
    before = so_far(tmp_path, "1", DESCRIPTOR)
    assert before.path == tmp_path / "session-1.part2.mcap"
    assert (before.files, before.done) == ((), {})
    (said,) = before.unreadable
    assert str(first) in said
    record(before.path)
    after = so_far(tmp_path, "1", DESCRIPTOR)
    assert after.path == tmp_path / "session-1.part3.mcap"
    assert (after.files, after.done[LABEL]) == ((before.path,), 1)
    assert first.read_bytes() == left


@pytest.mark.parametrize("length", [0, 41, 4096, 8192])
def test_the_folder_of_such_a_part_is_still_a_dataset(
    tmp_path: Path, length: int, capsys: pytest.CaptureFixture[str]
) -> None:
    left = tmp_path / "session-1.mcap"
    cut_to(left, length)
    record(tmp_path / "session-1.part2.mcap")
    dataset = load_dataset(tmp_path)
    assert len(dataset) == 1
    assert sum(str(left) in loss for loss in dataset.losses) == 1
    assert set(dataset.losses) <= set(dataset.notes)
    out = tmp_path / "o.csv"
    assert main(["export", str(tmp_path), "--to", "csv", "--out", str(out)]) == 0
    assert str(left) in capsys.readouterr().out
    with pytest.raises(InputError, match=r"session-1\.mcap"):
        load_dataset(left)


def test_a_folder_of_nothing_else_is_refused_with_the_reason(tmp_path: Path) -> None:
    for name in ("session-1.mcap", "session-1.part2.mcap"):
        cut_to(tmp_path / name, 4096)
    with pytest.raises(InputError, match=r"no whole pinch \(.*session-1\.mcap"):
        load_dataset(tmp_path)


def test_another_sessions_file_of_the_same_name_is_still_refused(tmp_path: Path) -> None:
    record(tmp_path / "session-a-b.mcap")
    with pytest.raises(InputError, match="belongs to session '1'"):
        so_far(tmp_path, "a b", DESCRIPTOR)
