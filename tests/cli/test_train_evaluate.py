"""From recordings to a model and its scores, and what is refused on the way."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.cli.main import main
from firstcontact.core import Contact, Dataset, Finger, Label, Pinch, Role, fingertip_layout
from firstcontact.recording import Header, write_dataset

LAYOUT = fingertip_layout()
CONTACT, LENGTH = 500, 700


def touch(shore: float, label: Label, rng: np.random.Generator, known: bool = True) -> Pinch:
    """Quiet, then a damped oscillation of the index finger's piezo; the thumb hears little."""
    data = np.zeros((LENGTH, len(LAYOUT.channels)))
    data[:, :2] = 16384 + rng.normal(0, 60, (LENGTH, 2))
    t = np.arange(LENGTH - CONTACT) / LAYOUT.rate
    hard = shore + rng.normal(0, 1)
    wave = np.sin(2 * np.pi * 60 * np.exp(hard / 35) * t) * np.exp(-t / 0.006)
    data[CONTACT:, 0] += 150 * hard * rng.lognormal(0, 0.1) * wave
    truth = (Contact(Finger.INDEX, CONTACT, CONTACT),) if known else ()
    return Pinch(np.clip(data, 0, 32767).astype(np.int16), LAYOUT, label, truth=truth)


def recordings(
    folder: Path, sessions: tuple[str, ...] = ("a", "b", "c", "d"), known: bool = True
) -> Path:
    """Five pinches of each of three blocks in each session, and an unseen object in its own."""
    rng = np.random.default_rng(0)
    pinches = []
    for session in sessions:
        for shore in (10.0, 29.0, 60.0):
            label = Label(f"block {shore:g}", shore, None, f"block {shore:g}", session)
            pinches += [touch(shore, label, rng, known) for _ in range(5)]
    unseen = Label("apple", 28.0, None, "apple 1", "objects", Role.TEST)
    pinches += [touch(28.0, unseen, rng, known) for _ in range(4)]
    folder.mkdir()
    write_dataset(Dataset(tuple(pinches), "synthetic"), folder, Header(LAYOUT, "synthetic"))
    return folder


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recordings(tmp_path_factory.mktemp("train") / "pinches")


def run(*words: Any) -> int:
    return main([str(w) for w in words])


def card_of(folder: Path) -> Any:
    return json.loads((folder / "card.json").read_text(encoding="utf-8"))


def test_a_model_knows_what_it_learned_and_what_was_held_out(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--out", tmp_path / "m") == 0
    said = capsys.readouterr().out
    card = card_of(tmp_path / "m")
    assert card["kind"] == "svm"
    assert card["data"]["pinches"] == 60  # and none of role "test"
    assert card["data"]["sessions"] == ["a", "b", "c", "d"]
    assert card["data"]["levels"] == [10.0, 29.0, 60.0]
    assert card["scores"]["n"] == 60  # each session was held out once
    assert card["scores"]["rmse"] < 10
    assert f"rmse {card['scores']['rmse']:.2f}" in said
    assert "4 sessions in 4 folds" in card["split"]


def test_seen_and_unseen_are_told_apart(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--out", tmp_path / "m") == 0
    capsys.readouterr()
    assert run("evaluate", tmp_path / "m", data) == 0
    said = capsys.readouterr().out
    assert "warning: 60 pinches are of sessions and specimens that the model learned from" in said
    unseen, seen = said.split("\nseen in training:")
    assert "4 pinches" in unseen
    assert "apple 1" in unseen
    assert "apple 1" not in seen
    assert "block 60" in seen

    other = recordings(tmp_path / "other", ("e", "f"))
    assert run("evaluate", tmp_path / "m", other) == 0
    said = capsys.readouterr().out
    assert "warning" not in said
    new, familiar = said.split("\nspecimens of the training, other sessions:")
    assert "4 pinches" in new
    assert "apple 1" in new
    assert "30 pinches" in familiar


def test_a_stranger_with_the_same_session_name_is_not_seen_in_training(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--out", tmp_path / "m") == 0
    rng = np.random.default_rng(5)
    label = Label("ball", 40.0, None, "ball 1", "a")
    pinches = tuple(touch(40.0, label, rng, True) for _ in range(5))
    folder = tmp_path / "stranger"
    folder.mkdir()
    write_dataset(Dataset(pinches, "synthetic"), folder, Header(LAYOUT, "synthetic"))
    capsys.readouterr()
    assert run("evaluate", tmp_path / "m", folder) == 0
    said = capsys.readouterr().out
    assert "warning" not in said
    assert "sessions of the training by name, other specimens:" in said


def test_a_specimen_of_one_pinch_has_no_spread(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--out", tmp_path / "m") == 0
    pinch = touch(40.0, Label("ball", 40.0, None, "b", "z"), np.random.default_rng(6), True)
    folder = tmp_path / "one"
    folder.mkdir()
    write_dataset(Dataset((pinch,), "synthetic"), folder, Header(LAYOUT, "synthetic"))
    assert run("evaluate", tmp_path / "m", folder) == 0
    assert "–" in capsys.readouterr().out.splitlines()[-1]


@pytest.mark.parametrize("model", ["peak", "train_mean", "cnn"])
def test_every_model_classifies_from_the_command_line(
    data: Path, tmp_path: Path, model: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m"
    assert run("train", data, "--model", model, "--task", "classification", "--out", out) == 0
    assert card_of(out)["classes"] == [10.0, 29.0, 60.0]
    assert run("evaluate", out, data) == 0
    said = capsys.readouterr().out
    assert "accuracy" in said
    assert "4 pinches are of no class" in said


def test_without_known_contacts_they_are_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = recordings(tmp_path / "pinches", known=False)
    assert run("train", data, "--contacts", "truth", "--out", tmp_path / "m") == 2
    assert "no pinch has a known first contact" in capsys.readouterr().err
    assert not (tmp_path / "m").exists()
    assert run("train", data, "--out", tmp_path / "m") == 0
    assert card_of(tmp_path / "m")["data"]["contacts"] == "detected (three_sigma)"
    assert run("evaluate", tmp_path / "m", data) == 0


def test_the_detector_learns_from_known_contacts(data: Path, tmp_path: Path) -> None:
    assert run("train", data, "--contacts", "detected", "--out", tmp_path / "m") == 0
    assert card_of(tmp_path / "m")["data"]["contacts"] == (
        "detected (svm that learned from other sessions)"
    )


def test_one_session_is_split_at_random_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = recordings(tmp_path / "pinches", ("a",))
    assert run("train", data, "--model", "peak", "--out", tmp_path / "m") == 0
    assert "random pinches, which flatters" in capsys.readouterr().out
    assert "random pinches, which flatters" in card_of(tmp_path / "m")["split"]


def test_the_same_seed_gives_the_same_files(data: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        assert run("train", data, "--seed", 4, "--out", tmp_path / name) == 0
    for file in ("card.json", "model.safetensors"):
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()


def test_another_rate_is_refused(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", data, "--model", "peak", "--out", tmp_path / "m") == 0
    fast = replace(LAYOUT, rate=16000.0)
    rng = np.random.default_rng(0)
    pinch = touch(10.0, Label("block", 10.0, None, "x", "z"), rng)
    (tmp_path / "fast").mkdir()
    write_dataset(
        Dataset((replace(pinch, layout=fast),), "synthetic"),
        tmp_path / "fast",
        Header(fast, "synthetic"),
    )
    capsys.readouterr()
    assert run("evaluate", tmp_path / "m", tmp_path / "fast") == 2
    assert "at 4936 Hz but these have 16000 Hz" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("labels", "sentence"),
    [
        ({"shore_a": None}, "no pinch has a shore_a"),
        ({"role": Role.TEST}, 'all pinches have role "test"'),
        ({}, "too few"),
    ],
)
def test_what_cannot_be_learned_from(
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


@pytest.mark.parametrize("words", [("--window-ms", "0.1"), ("--window-ms", "nan"), ("--seed", -1)])
def test_impossible_settings(data: Path, tmp_path: Path, words: tuple[Any, ...]) -> None:
    assert run("train", data, "--out", tmp_path / "m", *words) == 2


def test_a_folder_without_a_model(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("evaluate", tmp_path, data) == 2
    assert "there is no model here" in capsys.readouterr().err
