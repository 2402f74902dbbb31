"""Data of every source are loaded as recordings at the models' rate."""

import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs import Serial
from firstcontact_lab.study.part import StudySettings
from firstcontact_lab.study.run import recorded, simulated

TINY = replace(StudySettings(), block_pinches=2, object_pinches=1, workers=1)


def arrays(path: Path, rate: float = 8000.0) -> Path:
    rng = np.random.default_rng(0)
    np.savez(
        path,
        piezo=0.01 * rng.standard_normal((4, 3000, 1)),
        shore_a=np.array([10.0, 10.0, 40.0, 40.0]),
        first_contact=np.array([2000] * 4),
        sample_rate_hz=rate,
        piezo_unit="V",
    )
    return path


def test_the_twin_is_read_back_from_its_recordings_and_may_be_made_again(tmp_path: Path) -> None:
    for _ in range(2):
        dataset = simulated("paper-rig", TINY, tmp_path, Serial())
        assert dataset.source == "twin"
        assert len(dataset) == 5 * 2 + 8
    assert list((tmp_path / "recordings" / "paper-rig").rglob("*.mcap"))


def test_arrays_are_imported_resampled_and_that_is_noted(tmp_path: Path) -> None:
    dataset = recorded(arrays(tmp_path / "a.npz"), tmp_path / "out")
    assert dataset.layout.rate == FINGERTIP_RATE
    assert any("Resampled from 8000 Hz" in note for note in dataset.notes)
    first = dataset.pinches[0]
    assert first.first.sample - first.first_sample == round(2000 * FINGERTIP_RATE / 8000)
    again = recorded(tmp_path / "out" / "recordings" / "imported", tmp_path / "other")
    assert len(again) == len(dataset)
    assert not (tmp_path / "other").exists()


def test_what_an_earlier_study_left_is_not_swept_up(tmp_path: Path) -> None:
    out = tmp_path / "firstcontact-study"
    made = out / "recordings" / "imported"
    recorded(arrays(tmp_path / "a.npz"), out)
    with pytest.raises(InputError, match=f"only .* {re.escape(str(made))}:"):
        recorded(tmp_path, out)
    mine = next(made.rglob("*.mcap"))
    shutil.copy(mine, tmp_path / "mine.mcap")
    with pytest.raises(InputError, match=f"further .* {re.escape(str(made))}:"):
        recorded(tmp_path, out)
    assert len(recorded(tmp_path / "mine.mcap", out)) == len(recorded(made, out)) == 4


def test_bad_input_leaves_nothing_behind(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nowhere does not exist"):
        recorded(tmp_path / "nowhere", tmp_path / "out")
    (tmp_path / "bad.npz").write_bytes(b"no")
    with pytest.raises(InputError, match=r"bad\.npz"):
        recorded(tmp_path / "bad.npz", tmp_path / "out")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="is an empty folder"):
        recorded(tmp_path / "empty", tmp_path / "out")
    assert not (tmp_path / "out" / "recordings").exists()
