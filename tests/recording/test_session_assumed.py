"""Whether somebody named the session is a field of the header, for old recordings too."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import Dataset, fingertip_layout
from firstcontact.recording import Header, import_path, load_dataset, read_recording
from firstcontact.recording._header import read_header
from firstcontact.signal import resample_dataset

#: As importers wrote it into the notes before there was a field.
OLD = "imported from x.csv\nno session column: all pinches were taken as one session"


def imported(folder: Path, **more: object) -> Path:
    noise = np.random.default_rng(0).normal(0, 0.01, (3, 400, 1)).astype(np.float32)
    np.savez(folder / "x.npz", piezo=noise, sample_rate_hz=8000, piezo_unit="V", **more)
    import_path(folder / "x.npz", folder / "out")
    return folder / "out"


@pytest.mark.parametrize(("named", "assumed"), [({}, True), ({"session": ["a"] * 3}, False)])
def test_an_importer_says_it(tmp_path: Path, named: dict[str, object], assumed: bool) -> None:
    out = imported(tmp_path, **named)
    (file,) = out.iterdir()
    assert read_recording(file).header.session_assumed is assumed
    dataset = load_dataset(out)
    for same in (dataset, dataset.take([0, 1]), resample_dataset(dataset, 5000)):
        assert same.sessions_assumed is assumed


def test_one_of_several_is_enough(tmp_path: Path) -> None:
    for name, more in (("a", {}), ("b", {"session": ["a"] * 3})):
        (tmp_path / name).mkdir()
        imported(tmp_path / name, **more)
    assert load_dataset(tmp_path).sessions_assumed


def header(notes: str, **more: object) -> bytes:
    return json.dumps({**Header(fingertip_layout(), notes=notes).to_json(), **more}).encode()


@pytest.mark.parametrize(
    ("data", "assumed"),
    [
        (header(OLD), True),
        (header("x", session_assumed=True), True),
        (header("x", session_assumed=False), False),
        (header("the CSV had no session column: I asked who made it"), False),
        (header("x"), False),
    ],
)
def test_a_header_is_read(data: bytes, assumed: bool) -> None:
    assert read_header(data, "x").session_assumed is assumed


def test_a_named_session_leaves_no_trace_in_the_file() -> None:
    assert "session_assumed" not in Header(fingertip_layout()).to_json()
    assert not Dataset(()).sessions_assumed
