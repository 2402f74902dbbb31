"""Training from recordings to a model and its scores, with refusals."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.contact import DETECTORS, load_detector
from firstcontact.core import Dataset, Label, Role
from firstcontact.models import load_model
from firstcontact.recording import Header, write_dataset
from firstcontact.recording.dataset import find_recordings
from saved import CARD, WEIGHTS
from trainings import LAYOUT, load_card, recordings, run, touch


@pytest.fixture(scope="module")
def trained(data: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Folders of two trainings, whose windows begin at "known" and at "detected" contacts."""
    folder = tmp_path_factory.mktemp("trained")
    for contacts in ("known", "detected"):
        words = ("--estimator", "peak", "--contacts", contacts)
        assert run("train", data, "--out", folder / contacts, *words) == 0
    return {contacts: folder / contacts for contacts in ("known", "detected")}


def test_a_model_knows_what_it_learned_and_what_was_held_out(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--out", tmp_path / "m") == 0
    output = capsys.readouterr().out
    card = load_card(tmp_path / "m")
    default, part = card["predictors"]  # nothing was asked for: the network predicts
    assert default["kind"] == "combined"
    record = part["record"]
    assert part["kind"] == "svm"
    assert record["pinches"] == card["trained_on"]["pinches"] == 60  # and none of role "test"
    assert card["trained_on"]["sessions"] == ["a", "b", "c", "d"]
    assert card["trained_on"]["levels"] == [10.0, 29.0, 60.0]
    assert card["trained_on"]["objects"] == {"block 10": 10.0, "block 29": 29.0, "block 60": 60.0}
    assert record["scores"]["n"] == 60  # each session was held out once
    assert record["scores"]["rmse"] < 10
    assert f"rmse {record['scores']['rmse']:.2f}" in output
    assert "4 sessions in 4 folds" in record["split"]


def test_a_model_classifies_from_the_command_line(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m"
    assert run("train", data, "--estimator", "peak", "--task", "classification", "--out", out) == 0
    assert load_card(out)["predictors"][0]["classes"] == [10.0, 29.0, 60.0]
    assert run("evaluate", out, data) == 0
    output = capsys.readouterr().out
    assert "accuracy" in output
    assert "left out 4 pinches of classes" in output


def test_unknown_contacts_are_detected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = recordings(tmp_path / "pinches", has_contacts=False)
    assert run("train", data, "--contacts", "known", "--out", tmp_path / "m") == 2
    assert "no pinch has a known first contact" in capsys.readouterr().err
    assert not (tmp_path / "m").exists()
    assert run("train", data, "--out", tmp_path / "m") == 0
    assert load_card(tmp_path / "m")["trained_on"]["contacts"] == (
        "detected (logistic; steady states begin with the first sample)"
    )
    assert run("evaluate", tmp_path / "m", data) == 0


def test_the_same_seed_gives_the_same_files(
    data: Path, trained: dict[str, Path], tmp_path: Path
) -> None:
    words = ("--estimator", "peak", "--contacts", "known", "--seed", 0)
    assert run("train", data, "--out", tmp_path / "m", *words) == 0
    for file in (CARD, WEIGHTS, "detector.json", "detector.safetensors"):
        assert (tmp_path / "m" / file).read_bytes() == (trained["known"] / file).read_bytes()


@pytest.mark.parametrize(
    ("labels", "sentence"),
    [
        ({"shore_a": None}, "no pinch has a label shore_a"),
        ({"role": Role.TEST}, 'all pinches have role "test"'),
        ({}, "too few"),
    ],
)
def test_unusable_training_data_are_refused(
    tmp_path: Path, labels: dict[str, Any], sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    rng = np.random.default_rng(0)
    label = replace(Label("block", 10.0, None, "x", "z"), **labels)
    pinches = tuple(touch(10.0, label, rng) for _ in range(3))
    (tmp_path / "p").mkdir()
    write_dataset(Dataset(pinches, "synthetic"), tmp_path / "p", Header(LAYOUT, "synthetic"))
    assert run("train", tmp_path / "p", "--out", tmp_path / "m") == 2
    err = capsys.readouterr().err
    assert sentence in err
    assert err.count("\n") == 1
    assert not (tmp_path / "m").exists()


def test_a_regression_has_an_interval_that_was_checked_on_other_folds(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--estimator", "peak", "--level", 0.8, "--out", tmp_path / "m") == 0
    output = capsys.readouterr().out
    window = load_model(tmp_path / "m").windows[0]
    interval = window.interval
    assert interval.level == 0.8
    checked = window.record.calibration["held_out"]
    assert window.record.calibration["sessions"] == 4
    # One fold of 15 is asked with bounds from the 45 others.
    assert checked["n"] == 60
    assert 0.6 < checked["coverage"] <= 1.0
    assert f"held the truth in {100 * checked['coverage']:.1f} % of 60 pinches" in output

    assert run("evaluate", tmp_path / "m", data) == 0
    output = capsys.readouterr().out
    assert output.count("  interval at level 0.8 held the truth in ") == 2  # seen, unseen objects


def test_several_windows_make_a_model_each_beside_one_detector(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m"
    assert run("train", data, "--estimator", "peak", "--window-ms", 8, 3, 7.5, "--out", out) == 0
    model = load_model(out)
    assert [w.duration for w in model.windows] == [0.003, 0.0075, 0.008]
    assert [w.model.spec.samples for w in model.windows] == [15, 37, 39]
    assert all(w.interval is not None for w in model.windows)
    assert model.own_detector.name == DETECTORS.default
    assert model.network is not None
    assert sorted(p.name for p in out.iterdir()) == [
        "detector.json",
        "detector.safetensors",
        CARD,
        WEIGHTS,
    ]


@pytest.mark.parametrize(
    "words",
    [("--window-ms", "0.1"), ("--window-ms", "nan"), ("--window-ms", 3, 3), ("--seed", -1)]
    + [("--level", level) for level in (1, "nan")]
    + [("--rate", rate) for rate in (-1, 10, 1e18, "nan")],
)
def test_impossible_settings_leave_the_model(
    data: Path, trained: dict[str, Path], words: tuple[Any, ...]
) -> None:
    out = trained["known"]
    original = (out / CARD).read_bytes()
    assert run("train", data, "--out", out, *words) == 2
    assert (out / CARD).read_bytes() == original


@pytest.fixture(scope="module")
def model(data: Path) -> Path:
    assert run("train", data, "--estimator", "peak", "--out", data.parent / "model") == 0
    return data.parent / "model"


@pytest.mark.parametrize("name", DETECTORS)
def test_every_detector_is_made_alone_and_used_beside_a_model(
    name: str, data: Path, model: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "detector"
    assert run("train", data, "--detector-type", name, "--detector-only", "--out", out) == 0
    assert f"wrote the detector {name} to {out}" in capsys.readouterr().out
    assert load_detector(out).name == name
    assert not list(out.glob("model.json"))
    using = ("--detector", out)
    assert run("evaluate", model, data, "--contacts", "detected", *using) == 0
    assert f"contacts detected ({name};" in capsys.readouterr().out
    device = ("--device", find_recordings(data)[0], "--speed", "inf", "--model", model)
    assert run("live", *device, *using) == 0


def test_a_detector_that_cannot_learn_is_no_other_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    unknown = recordings(tmp_path / "unknown", has_contacts=False)
    arguments = ("train", unknown, "--out", tmp_path / "m", "--detector-type", "svm")
    assert run(*arguments) == 2
    assert "0 pinches" in capsys.readouterr().err
    assert not (tmp_path / "m").exists()
