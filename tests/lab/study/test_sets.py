"""Scores of detectors on sets of real recordings."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.contact import DETECTORS
from firstcontact.core import Block, Dataset
from firstcontact.recording import Header, RecordingWriter, write_dataset
from firstcontact_lab.study.page import read_study
from firstcontact_lab.study.sets import NOISE, SET


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
