"""Evaluation of saved models: recordings at any rate, and overlap with the training data."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from firstcontact.core import Dataset, Role
from firstcontact.recording import Header, load_dataset, write_dataset
from trainings import LAYOUT, recordings, resampled, run


@pytest.fixture(scope="module")
def svm(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an SVM trained on the pinches. No test may change it."""
    return trained(data, tmp_path_factory.mktemp("svm") / "m")


@pytest.fixture(scope="module")
def peak(data: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a peak model, which trains faster. No test may change it."""
    return trained(data, tmp_path_factory.mktemp("peak") / "m", "--estimator", "peak")


def trained(data: Path, out: Path, *words: str) -> Path:
    assert run("train", data, "--out", out, *words) == 0
    return out


def test_seen_and_unseen_are_told_apart(
    data: Path, svm: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert run("evaluate", svm, data) == 0
    output = capsys.readouterr().out
    assert "warning: 60 pinches have the same samples as training pinches" in output
    # Of the any-time model first, then of the one of a window.
    unseen, seen = output[output.index("\n15 ms, ") :].split("\nseen in training:")
    assert "4 pinches" in unseen
    assert "apple 1" in unseen
    assert "apple 1" not in seen
    assert "block 60" in seen

    other = recordings(tmp_path / "other", ("e", "f"), seed=1)
    assert run("evaluate", svm, other) == 0
    output = capsys.readouterr().out
    assert "warning" not in output
    of_window = output[output.index("\n15 ms, ") :]
    new, familiar = of_window.split("\nspecimens of the training, other sessions:")
    assert "4 pinches" in new
    assert "apple 1" in new
    assert "30 pinches" in familiar


@pytest.mark.parametrize(("rate", "contacts"), [(5200.0, "detected"), (16000.0, "known")])
def test_recordings_of_another_rate_are_resampled_with_a_note(
    data: Path,
    peak: Path,
    tmp_path: Path,
    rate: float,
    contacts: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    capsys.readouterr()
    assert run("evaluate", peak, data, "--contacts", contacts) == 0
    present = capsys.readouterr().out
    other = resampled(data, rate, tmp_path / "other")
    assert run("evaluate", peak, other, "--contacts", contacts) == 0
    output = capsys.readouterr().out
    assert f"Resampled from {rate:g} Hz to 4936 Hz" in output
    scored = "60 pinches, " if contacts == "known" else " pinches, "
    assert scored in output
    # The same pinches: twice resampled they give nearly the same errors.
    error = [float(re.findall(r"rmse ([0-9.]+) ", text)[0]) for text in (present, output)]
    assert error[1] == pytest.approx(error[0], abs=1.5)


@pytest.mark.parametrize("route", ["renamed", "hdf5"])
def test_pinches_learned_from_are_known_by_any_name(
    data: Path, peak: Path, tmp_path: Path, route: str, capsys: pytest.CaptureFixture[str]
) -> None:
    again = tmp_path / "again"
    if route == "renamed":
        other = {"session": "z", "specimen": "other", "role": Role.TEST}
        pinches = [replace(p, label=replace(p.label, **other)) for p in load_dataset(data)]
        again.mkdir()
        write_dataset(Dataset(tuple(pinches), "real"), again, Header(LAYOUT, "real"))
    else:
        assert run("export", data, "--to", route, "--out", tmp_path / f"all.{route}") == 0
        assert run("import", tmp_path / f"all.{route}", "--out", again) == 0
    capsys.readouterr()
    assert run("evaluate", peak, again) == 0
    output = capsys.readouterr().out
    assert "warning: 60 pinches have the same samples as training pinches" in output
    assert "\nseen in training: " in output


def test_an_any_time_model_is_scored_by_the_time_after_contact(
    data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("adapt", data, "--out", tmp_path / "m") == 0
    capsys.readouterr()
    assert run("evaluate", tmp_path / "m", data) == 0
    output = capsys.readouterr().out
    assert "64 pinches scored" in output
    assert [line.split()[0] for line in output.splitlines()[-5:]] == ["2", "3", "5", "8", "15"]
    assert "rmse" in output
    # The rig is known by all but the test object, and these are told apart.
    assert "60 pinches have the same samples as training pinches" in output
    assert "not seen in training: 4 pinches" in output
    assert "\nseen in training: 60 pinches" in output

    # Beside a model of one window length, both are scored.
    assert run("train", data, "--estimator", "peak", "--out", tmp_path / "both") == 0
    capsys.readouterr()
    assert run("evaluate", tmp_path / "both", data) == 0
    output = capsys.readouterr().out
    assert output.index("at any time") < output.rindex("seen in training:")
