"""Training of a detector alone, and its use with a model that was trained with another one."""

from pathlib import Path

import pytest

from firstcontact.contact import DETECTORS, load_detector
from firstcontact.recording.dataset import find_recordings
from trainings import recordings, run


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
    assert f"detector {name}: {out}" in capsys.readouterr().out
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
