"""Data of every source are loaded as recordings, and sets of real recordings scored."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.contact import DETECTORS
from firstcontact.core import Block, Dataset, InputError
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.jobs import Serial
from firstcontact.recording import Header, RecordingWriter, write_dataset
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.part import StudySettings
from firstcontact_lab.study.run import recorded, simulated
from firstcontact_lab.study.sets import NOISE, SET

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


@pytest.fixture
def folder(tmp_path: Path, shore: Dataset) -> Path:
    """Folder of one set with contacts, noise and a front end."""
    dtype = str(shore.pinches[0].data.dtype)
    header = Header(shore.layout, "synthetic", dtype)
    for place in ("sets/toys/recordings", "sets/toys/noise", "twin"):
        (tmp_path / place).mkdir(parents=True)
    write_dataset(shore, tmp_path / "sets" / "toys" / "recordings", header)
    write_dataset(shore, tmp_path / "twin", header)
    rng = np.random.default_rng(0)
    quiet = rng.normal(0, 5, (40_000, shore.layout.width)).astype(dtype)
    with RecordingWriter(tmp_path / "sets/toys/noise/quiet.mcap", header) as writer:
        writer.write(Block(quiet, 0))
    (tmp_path / "sets/toys/front_ends.csv").write_text("session,front_end\n*,a test\n")
    return tmp_path / "sets"


def test_every_detector_is_scored_and_the_page_written(folder: Path) -> None:
    twin, other_noise = folder.parent / "twin", folder.parent / "other_noise"
    shutil.copytree(twin, other_noise)
    words = ["sets", str(folder), "--twin", str(twin), "--noises", str(other_noise)]
    assert main([*words, str(other_noise)]) == 2
    assert main(words) == 0
    results = read_study(folder / "results.json").about[SET]
    assert results.n > 0
    assert results.front_end == "a test"
    assert results.training == "others"
    assert results.placed_2_ms > 0.9
    assert results.noise_seconds > 1
    assert results.noise_false_alarms_per_minute is not None
    ways = {name: set(computed) for name, computed in (results.detectors or {}).items()}
    learned = {"twin", "others"}
    assert ways == {n: learned if d.learns else {"nothing"} for n, d in DETECTORS.items()}
    tree = json.loads((folder / "results.json").read_text())["set"]
    assert set(tree["delay_ms"]) == {"median", "p95"}
    page = (folder / "report.html").read_text()
    assert "a test" in page
    assert "Toys" in page

    over_noise = read_study(folder / "results.json")["other_noise"][NOISE]
    assert set(over_noise.detectors) == set(DETECTORS)
    assert over_noise.noise == "as modelled"
    assert over_noise.estimated > 0
    assert over_noise.rmse < 20  # the very pinches that it learned from, here
    assert "other noise" in page


def test_a_folder_without_sets_is_refused_in_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sets", str(tmp_path), "--twin", str(tmp_path)]) == 2
    assert "contains no set" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
