"""A whole study of synthetic pinches: which results are present, and an interruption."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.jobs import Serial
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.page import State
from firstcontact_lab.report.run import Job, run_jobs
from firstcontact_lab.study.detection import detection_splits
from firstcontact_lab.study.part import StudySettings
from firstcontact_lab.study.run import plan
from partial import study_state

#: `make quick` draws the figures of a study.
pytestmark = pytest.mark.usefixtures("unpainted", "own_estimators")
SMALL = replace(StudySettings(), durations=(0.005, 0.015), folds=3, brief=True, calls=30, workers=1)


def study(dataset: Dataset, out: Path, name: str = "recordings") -> tuple[State, list]:
    return study_state(SMALL, quick=True), plan([(name, lambda: dataset)], SMALL, Serial())


def results(out: Path) -> dict:
    return json.loads((out / "results.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def study_folder(shore: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a finished study. Its files were complete after every part."""
    out = tmp_path_factory.mktemp("study")
    state, steps = study(shore, out)
    seen: list[int] = []

    def tick(job: Job) -> None:
        if state.completed:
            tree = results(out)
            assert len(tree["pending"]) == len(steps) - state.completed
            assert "Still running" in (out / "report.html").read_text(encoding="utf-8")
            seen.append(state.completed)

    run_jobs(steps, state, out, tick)
    assert seen == list(range(1, len(steps)))
    return out


def test_results_have_the_promised_keys(study_folder: Path) -> None:
    tree = results(study_folder)
    assert set(tree["data"]) >= {"source", "pinches", "specimens", "sample_rate_hz"}
    assert set(tree["offset_ms"]) >= {"mean", "sd", "share_below_15"}
    for detector in ("three_sigma", "svm"):
        scores = tree["contact"][detector]
        assert set(scores) >= {"window_accuracy", "pinch_success", "false_alarms_per_minute"}
    assert set(tree["contact"]["svm"]["delay_ms"]) == {"median", "p95"}
    for model in ("train_mean", "peak", "svm", "cnn"):
        for split in ("random_90_10", "by_session"):
            assert set(tree["blocks"][model][split]) >= {"accuracy", "rmse", "mae", "mse"}
        assert set(tree["blocks"][model]["leave_one_shore_out"]["per_level"]) == {"10", "30", "60"}
        assert set(tree["objects"][model]) >= {"rmse", "mae", "mse", "bias", "per_object"}
    assert set(tree["objects"]["svm"]["per_object"]) == {"fruit 20", "fruit 50"}
    assert set(tree["answer_ms"]["window_length_ms"]) == {"5", "15"}
    for model in ("svm", "cnn"):
        assert set(tree["inference_us"][model]) >= {"p50", "p99"}
    assert set(tree["inference_us"]["svm"]["classification"]) >= {"p50", "p99"}
    assert 0 < tree["inference_us"]["svm"]["support_vectors"] <= 36
    assert "support_vectors" not in tree["inference_us"]["cnn"]
    assert tree["seconds"] > 0
    assert tree["study"]["complete"]
    assert "pending" not in tree
    assert "null" not in (study_folder / "results.json").read_text(encoding="utf-8")


def test_floors_are_what_they_say(study_folder: Path, shore: Dataset) -> None:
    tree = results(study_folder)
    floor = tree["blocks"]["train_mean"]["leave_one_shore_out"]
    levels = np.array([10.0, 30.0, 60.0])
    remaining = np.array([45.0, 35.0, 20.0])
    assert floor["rmse"] == pytest.approx(np.sqrt(((levels - remaining) ** 2).mean()))
    assert tree["blocks"]["svm"]["by_session"]["rmse"] < floor["rmse"]


def test_the_page_needs_nothing_else(study_folder: Path) -> None:
    page = (study_folder / "report.html").read_text(encoding="utf-8")
    for tag in ("<script", "<link", 'src="http', "url(http", "@import"):
        assert tag not in page
    assert page.count('src="data:image/svg+xml;base64,') >= 5
    assert 'id="claims"' in page
    assert "Still running" not in page


def test_ranks_only_leave_shore_out_and_say_so(ranks: Dataset, tmp_path: Path) -> None:
    state, steps = study(ranks, tmp_path)
    # Short windows: tests/lab/study/test_hard_labels.py has them in a study of ranks.
    titles = [step.title for step in steps]
    assert "short windows" in titles
    steps = [s for s in steps if "slow" not in s.title and s.title != "short windows"]
    run_jobs(steps, state, tmp_path)
    tree = results(tmp_path)
    assert set(tree) >= {"data", "contact", "hardness_order", "left_out"}
    assert not set(tree) & {"blocks", "objects", "offset_ms", "inference_us"}
    assert any("Unseen objects" in reason for reason in tree["left_out"])
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "What was left out, and why" in page
    assert "twin" not in page.split("</header>")[0].lower()


def test_without_known_contacts_the_threshold_finds_them(
    make_shore: Callable[..., Dataset], tmp_path: Path
) -> None:
    dataset = make_shore(each=10, objects=(), has_contacts=False)
    state, steps = study(dataset, tmp_path)
    wanted = ("data", "contact detection", "waveforms")
    run_jobs([s for s in steps if s.title in wanted], state, tmp_path)
    tree = results(tmp_path)
    assert set(tree["contact"]) == {"not_found", "steady_state", "windows_start_at"}
    assert tree["contact"]["windows_start_at"] == "three_sigma"
    assert tree["contact"]["not_found"]["by"] == "three_sigma"
    assert "offset_ms" not in tree
    assert "peak_v" in tree


def test_an_interrupt_keeps_earlier_results(shore: Dataset, tmp_path: Path) -> None:
    state, steps = study(shore, tmp_path)

    def interrupt() -> PartResult:
        raise KeyboardInterrupt

    steps[1] = replace(steps[1], run=interrupt)
    with pytest.raises(KeyboardInterrupt):
        run_jobs(steps, state, tmp_path)
    tree = results(tmp_path)
    assert "data" in tree
    assert not tree["study"]["complete"]
    assert "Interrupted." in (tmp_path / "report.html").read_text(encoding="utf-8")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report.html", "results.json"]


def test_detectors_are_judged_in_sessions_they_never_saw(shore: Dataset) -> None:
    splits = detection_splits(shore, 0)
    held_out = np.concatenate([s.test for s in splits])
    assert sorted(held_out) == list(range(len(shore)))
    for split in splits:
        split.check(shore.sessions, shore.specimens)
        assert not shore.test[split.train].any()


def test_names_from_recordings_are_text_not_markup(shore: Dataset, tmp_path: Path) -> None:
    evil = "<script>alert(1)</script>"
    pinches = tuple(
        replace(p, label=replace(p.label, specimen=evil, object=evil))
        if p.label.role == "test"
        else p
        for p in shore.pinches
    )
    state, steps = study(replace(shore, pinches=pinches, notes=(evil,)), tmp_path)
    wanted = ("data", "objects")
    run_jobs([s for s in steps if s.title in wanted], state, tmp_path)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert "&lt;script&gt;" in page
