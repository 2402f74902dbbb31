"""Header field that says that an importer assumed the sessions, also in old recordings."""

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


def import_arrays(folder: Path, **fields: object) -> Path:
    noise = np.random.default_rng(0).normal(0, 0.01, (3, 400, 1)).astype(np.float32)
    np.savez(folder / "x.npz", piezo=noise, sample_rate_hz=8000, piezo_unit="V", **fields)
    import_path(folder / "x.npz", folder / "out")
    return folder / "out"


@pytest.mark.parametrize(("named", "assumed"), [({}, True), ({"session": ["a"] * 3}, False)])
def test_importer_sets_the_assumed_session(
    tmp_path: Path, named: dict[str, object], assumed: bool
) -> None:
    out = import_arrays(tmp_path, **named)
    (file,) = out.iterdir()
    assert read_recording(file).header.session_assumed is assumed
    dataset = load_dataset(out)
    for variant in (dataset, dataset.take([0, 1]), resample_dataset(dataset, 5000)):
        assert variant.sessions_assumed is assumed


def test_one_assumed_session_marks_the_dataset(tmp_path: Path) -> None:
    for name, fields in (("a", {}), ("b", {"session": ["a"] * 3})):
        (tmp_path / name).mkdir()
        import_arrays(tmp_path / name, **fields)
    assert load_dataset(tmp_path).sessions_assumed


def header(notes: str, **fields: object) -> bytes:
    return json.dumps({**Header(fingertip_layout(), notes=notes).to_json(), **fields}).encode()


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
def test_assumed_session_is_read_from_the_header(data: bytes, assumed: bool) -> None:
    assert read_header(data, "x").session_assumed is assumed


def test_named_session_is_not_in_the_header() -> None:
    assert "session_assumed" not in Header(fingertip_layout()).to_json()
    assert not Dataset(()).sessions_assumed
