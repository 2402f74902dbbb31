"""Training replaces its folder completely or not at all."""

import shutil
from pathlib import Path

import pytest

import forked
from firstcontact.contact import load_detector
from firstcontact.core import InputError
from firstcontact.models import load_model
from processes import ON_FULL_DISK
from saved import CARD, WEIGHTS
from trainings import recordings, run

#: A named detector is fitted, so that two trainings differ in all files.
FITTED = ("--detector-type", "logistic")


@pytest.fixture(scope="module")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recordings(tmp_path_factory.mktemp("other") / "pinches", seed=1)


@pytest.fixture(scope="module")
def trained(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("trained") / "m"
    assert run("train", data, "--estimator", "peak", *FITTED, "--out", out) == 0
    return out


@pytest.fixture
def model(trained: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(trained, tmp_path / "m"))


def content(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.parametrize("size", [200, 10_000])
def test_a_full_disk_leaves_the_old_training(model: Path, other: Path, size: int) -> None:
    """The weights are written last and are the largest file, so earlier files may still fit."""
    original = content(model)
    assert len(original[WEIGHTS]) > 10_000
    words = ["train", str(other), "--estimator", "peak", "--out", str(model)]
    process = forked.run("code", ON_FULL_DISK, size, *words)
    assert process.returncode == 2, process.stderr
    assert f"{model}: File too large: make room" in process.stderr
    assert process.stderr.count("\n") == 1
    assert content(model) == original
    assert [p.name for p in model.parent.iterdir()] == ["m"]


def test_parts_of_two_trainings_are_no_model(
    model: Path, other: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("train", other, "--estimator", "peak", *FITTED, "--out", tmp_path / "n") == 0
    for name in ("detector.json", "detector.safetensors"):
        shutil.copy(tmp_path / "n" / name, model / name)
    load_detector(model)  # by itself it is one
    with pytest.raises(InputError, match=r"detector\.json "):
        load_model(model)
    capsys.readouterr()
    for contacts in ("known", "detected"):
        assert run("evaluate", model, other, "--contacts", contacts) == 2
        assert "detector.json" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["notes.txt", "pinches/a.mcap", "15ms/notes.txt", CARD])
def test_what_no_training_wrote_is_not_lost(
    data: Path, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m"
    (out / name).parent.mkdir(parents=True)
    (out / name).write_text('{"format": "of somebody else"}', encoding="utf-8")
    assert run("train", data, "--estimator", "peak", "--out", out) == 2
    assert "which is not part of a model" in capsys.readouterr().err
    assert list(content(out)) == [name]


def test_a_training_is_replaced_and_nothing_of_it_stays(
    model: Path, other: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    original = content(model)
    assert run("train", other, "--estimator", "train_mean", *FITTED, "--out", model) == 0
    assert f"replaced the former model in {model}" in capsys.readouterr().out
    current = content(model)
    assert current.keys() == original.keys()
    assert all(current[name] != original[name] for name in original)
    load_model(model)
    load_detector(model)
    assert [p.name for p in model.parent.iterdir()] == ["m"]


def test_models_that_training_would_not_remake_are_preserved(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "m"
    assert run("train", data, "--estimator", "peak", "--window-ms", 8, 3, "--out", out) == 0
    original = content(out)
    capsys.readouterr()
    assert run("train", data, "--estimator", "peak", "--out", out) == 2
    errors = capsys.readouterr().err
    assert "another folder" in errors
    assert str(out) in errors
    assert run("train", data, "--estimator", "peak", "--window-ms", 3, 15, "--out", out) == 2
    assert content(out) == original
    assert run("train", data, "--estimator", "peak", "--window-ms", 3, 7.5, 8, "--out", out) == 0
    capsys.readouterr()
    assert run("evaluate", out, data) == 0
    scored = capsys.readouterr().out.splitlines()
    assert [line.split(",")[0] for line in scored if ": contacts " in line] == [
        "3 ms", "7.5 ms", "8 ms", "at any time",
    ]  # fmt: skip


def test_a_reader_is_told_where_the_old_one_is(
    model: Path, data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The folder is as if the training was killed between the two renames of the replacement."""
    aside = model.with_name(".m.0123abcd.old")
    original = content(model)
    model.rename(aside)
    assert run("evaluate", model, data) == 2
    assert str(aside) in capsys.readouterr().err
    # A training that fails puts it back.
    assert run("train", data, "--estimator", "peak", "--window-ms", 900, "--out", model) == 2
    assert content(model) == original
    assert not aside.exists()
