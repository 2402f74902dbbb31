"""Sessions can be continued, even if a killed recorder left a damaged file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from firstcontact.collect.session import so_far
from firstcontact.core import Block, InputError, Label, fingertip_layout
from firstcontact.device import Descriptor
from firstcontact.recording import Header, PinchMark, RecordingWriter, load_dataset

LAYOUT = fingertip_layout()
DESCRIPTOR = Descriptor(LAYOUT, source="twin")
LABEL = Label("block 20", 20.0, None, "block 20", "1")


def record(path: Path, label: Label = LABEL) -> Path:
    """Write a complete recording of one pinch."""
    with RecordingWriter(path, Header(LAYOUT, "twin", session="1")) as writer:
        writer.write(Block(np.zeros((2000, 16), np.int16)))
        writer.mark(PinchMark(0, 100, 900, 0, label))
    return path


@pytest.mark.parametrize("length", [0, 41, 4096, 8192])
def test_session_continues_after_an_unreadable_part(tmp_path: Path, length: int) -> None:
    damaged = tmp_path / "session-1.mcap"
    content = record(damaged).read_bytes()[:length]
    damaged.write_bytes(content)
    progress = so_far(tmp_path, "1", DESCRIPTOR)
    assert progress.path == tmp_path / "session-1.part2.mcap"
    assert (progress.files, progress.counts) == ((), {})
    (message,) = progress.unreadable
    assert str(damaged) in message
    record(progress.path)
    resumed = so_far(tmp_path, "1", DESCRIPTOR)
    assert resumed.path == tmp_path / "session-1.part3.mcap"
    assert (resumed.files, resumed.counts[LABEL]) == ((progress.path,), 1)
    assert damaged.read_bytes() == content
    dataset = load_dataset(tmp_path)
    assert len(dataset) == 1
    assert sum(str(damaged) in loss for loss in dataset.losses) == 1
    with pytest.raises(InputError, match=r"session-1\.mcap"):
        load_dataset(damaged)


def test_file_of_another_session_is_refused(tmp_path: Path) -> None:
    record(tmp_path / "session-a-b.mcap")
    with pytest.raises(InputError, match=r"session-a-b\.mcap .*'1'") as error:
        so_far(tmp_path, "a b", DESCRIPTOR)
    assert error.value.parameter == "session"
