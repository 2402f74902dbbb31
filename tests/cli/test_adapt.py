"""``firstcontact adapt``: a model conditioned on a rig's recordings, or on no rig."""

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.contact import detect, load_detector
from firstcontact.core import Dataset
from firstcontact.models import Touches
from firstcontact.models.model_file import pretrained, read_card
from firstcontact.recording import Header, load_dataset, write_dataset
from firstcontact.testing import closings
from saved import load_network
from trainings import LAYOUT, run


@pytest.fixture(scope="module")
def rig(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a model conditioned on the rig of the block recordings. No test may change it."""
    out = tmp_path_factory.mktemp("rig") / "rig"
    assert run("adapt", data, "--out", out, "--seed", "3") == 0
    return out


def only(recorded: Path, out: Path, selected: Any) -> Path:
    """Write the pinches whose label meets a condition into a folder."""
    pinches = [p for p in load_dataset(recorded).pinches if selected(p.label)]
    out.mkdir()
    write_dataset(Dataset(tuple(pinches), "synthetic"), out, Header(LAYOUT, "synthetic"))
    return out


def test_recordings_make_a_model_that_knows_the_rig(
    data: Path, tmp_path: Path, capsys: Any
) -> None:
    out = tmp_path / "rig"
    assert run("adapt", data, "--out", out) == 0
    output = capsys.readouterr().out
    assert "3 Shore A levels" in output
    assert "held-out pinches" in output
    assert str(out) in output
    card = read_card(out)
    assert card.trained_on.levels == (10.0, 29.0, 60.0)
    assert card.trained_on.pinches == 60  # the apple has role "test"
    assert "detected" in card.trained_on.contacts
    [part] = card.predictors
    assert 50 <= part.record.pinches <= 60
    assert any(name.startswith("held out") for name in part.record.scores)
    assert load_detector(out).name
    dataset = load_dataset(data)
    touches, which = Touches.cut(dataset, [p.first for p in dataset.pinches])
    mine, unknown = (
        np.nanmean(np.abs(model.predict_touches(touches).value - dataset.shore_a[which]))
        for model in (load_network(out), pretrained())
    )
    assert mine < unknown


def test_the_same_seed_gives_the_same_bytes(data: Path, rig: Path, tmp_path: Path) -> None:
    assert run("adapt", data, "--out", tmp_path / "again", "--seed", "3") == 0
    for file in ("model.json", "weights.safetensors"):
        assert (rig / file).read_bytes() == (tmp_path / "again" / file).read_bytes()


def test_without_recordings_the_rig_is_unknown(tmp_path: Path, capsys: Any) -> None:
    out = tmp_path / "any"
    assert run("adapt", "--out", out) == 0
    assert "unknown rig" in capsys.readouterr().out
    assert read_card(out).trained_on.pinches == 0
    # Trained on the twin: the threshold of three sigmas fires early on most closings.
    detector, remaining = load_detector(out), closings(40, seed=1)
    placed = [next(iter(detect(detector, pinch)), None) for pinch in remaining.pinches]
    near = [
        contact is not None and abs(contact.sample - pinch.truth[0].sample) <= 15
        for contact, pinch in zip(placed, remaining.pinches, strict=True)
    ]
    assert np.mean(near) >= 0.95
    assert run("adapt", "--detector-type", "three_sigma", "--out", out) == 0
    assert load_detector(out).name == "three_sigma"


def test_what_cannot_be_used_is_refused_and_nothing_written(
    data: Path, tmp_path: Path, capsys: Any
) -> None:
    cases = {
        "one": (lambda label: label.shore_a == 29.0, "2 values of Shore A"),
        "tests": (lambda label: label.object == "apple", 'role "test"'),
    }
    for name, (selected, why) in cases.items():
        selection = only(data, tmp_path / name, selected)
        assert run("adapt", selection, "--out", tmp_path / "no") == 2
        errors = capsys.readouterr().err
        assert why in errors
        assert name in errors
        assert errors.count("\n") == 1
        assert not (tmp_path / "no").exists()
    assert run("adapt", tmp_path / "nowhere", "--out", tmp_path / "no") == 2
    assert run("adapt", "--detector-type", "svm", "--out", tmp_path / "no") == 2
    assert run("adapt", data, "--seed", "-1", "--out", tmp_path / "no") == 2
    assert not (tmp_path / "no").exists()


def test_a_training_is_not_torn_apart(data: Path, rig: Path, tmp_path: Path, capsys: Any) -> None:
    """The window models require their own detector. Another detector is refused."""
    trained = tmp_path / "trained"
    assert run("train", data, "--out", trained, "--estimator", "peak") == 0
    original = {path.name: path.read_bytes() for path in trained.iterdir()}
    capsys.readouterr()
    assert run("adapt", data, "--out", trained) == 2
    errors = capsys.readouterr().err
    assert "another folder" in errors
    assert str(trained) in errors
    assert {path.name: path.read_bytes() for path in trained.iterdir()} == original
    rig_copy = shutil.copytree(rig, tmp_path / "rig")
    assert run("adapt", "--out", rig_copy) == 0  # its own is replaced
    assert read_card(rig_copy).trained_on.pinches == 0
