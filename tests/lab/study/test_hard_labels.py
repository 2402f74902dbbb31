"""Incomplete labels: a study runs all possible parts, and states which it left out."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from firstcontact.core import Dataset, InputError, Label, Pinch, Role
from firstcontact.core.records import to_tree
from firstcontact.jobs import Serial
from firstcontact_lab.report.findings import PartResult
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.report.run import run_jobs
from firstcontact_lab.study.detection import detection_splits
from firstcontact_lab.study.part import StudySettings, Subject
from firstcontact_lab.study.parts.blocks import BLOCKS, blocks
from firstcontact_lab.study.parts.contacts import CONTACT, contacts
from firstcontact_lab.study.parts.hardness import HARDNESS, hardness
from firstcontact_lab.study.parts.inference import inference
from firstcontact_lab.study.parts.objects import measure_objects
from firstcontact_lab.study.parts.waveforms import PEAK, waveforms
from firstcontact_lab.study.run import plan
from partial import study_state

pytestmark = pytest.mark.usefixtures("unpainted", "own_estimators")

SMALL = replace(StudySettings(), durations=(0.005, 0.015), folds=3, brief=True, calls=30, workers=1)
MODELS = ("train_mean", "peak", "svm")


def relabel(dataset: Dataset, new: Callable[[int, Label], Label]) -> Dataset:
    pinches = tuple(replace(p, label=new(i, p.label)) for i, p in enumerate(dataset.pinches))
    return replace(dataset, pinches=pinches)


def cut(dataset: Dataset, first: int, last: int, rows: Sequence[int] | None = None) -> Dataset:
    """Return the pinches, all or those at ``rows``, cut to the samples ``first`` to ``last``."""

    def shorter(pinch: Pinch) -> Pinch:
        truth = tuple(c for c in pinch.truth if first <= c.sample < last)
        return replace(pinch, data=pinch.data[first:last], first_sample=first, truth=truth)

    chosen = range(len(dataset)) if rows is None else rows
    pinches = tuple(shorter(p) if i in chosen else p for i, p in enumerate(dataset.pinches))
    return replace(dataset, pinches=pinches)


def whole_study(dataset: Dataset, out: Path, *only: str) -> dict[str, Any]:
    """Run the steps with the titles ``only``, or all steps if none is given.

    Steps of slow estimators (the CNN) and the inference times never run.
    """
    steps = plan([("recordings", lambda: dataset)], SMALL, Serial())
    assert {"inference time", *only} <= {step.title for step in steps}
    steps = [s for s in steps if "slow" not in s.title and s.title != "inference time"]
    steps = [s for s in steps if not only or s.title in only]
    run_jobs(steps, study_state(SMALL, quick=True), out)
    text = (out / "results.json").read_text(encoding="utf-8")
    assert "null" not in text
    assert "NaN" not in text
    tree: dict[str, Any] = json.loads(text)
    assert tree["study"]["complete"]
    return tree


def reason_with(outcome: PartResult, word: str) -> str:
    results = [reason for reason in outcome.left_out if word in reason]
    assert len(results) == 1, outcome.left_out
    return results[0]


# -- specimens -----------------------------------------------------------------------------


def test_a_specimen_that_was_measured_twice_is_no_stranger(shore: Dataset) -> None:
    fruit = Label("fruit", 40.0, None, "fruit 1", "unseen", Role.TEST)

    def ripened(i: int, label: Label) -> Label:
        if i == 0:
            return replace(fruit, shore_a=35.0, session=label.session, role=Role.TRAIN)
        return fruit if label.role is Role.TEST else label

    outcome = measure_objects(Subject("x", relabel(shore, ripened)), SMALL, Serial(), MODELS)
    assert outcome.results is NOTHING
    assert "'fruit 1' of 'fruit' has both roles" in outcome.left_out[0]


# -- sessions ------------------------------------------------------------------------------


def test_each_level_in_one_session(make_shore: Callable[..., Dataset]) -> None:
    dataset = relabel(
        make_shore(objects=()), lambda i, label: replace(label, session=f"day of {label.shore_a}")
    )
    outcome = blocks(Subject("x", dataset), SMALL, Serial(), MODELS)
    reason = reason_with(outcome, "Discrimination by session")
    assert "levels 10, 30, 60 lie in one session each" in reason
    scores = to_tree(outcome.results[BLOCKS]["svm"])
    assert "accuracy" not in scores["by_session"]
    assert scores["by_session"]["n"] == len(dataset)
    assert "accuracy" in scores["random_90_10"]


# -- ranks ---------------------------------------------------------------------------------


def test_ranks_of_one_material_have_no_class(ranks: Dataset) -> None:
    dataset = ranks.take(np.isin(ranks.objects, ["mat", "box", "desk"]))
    outcome = hardness(Subject("x", dataset), SMALL, Serial())
    assert "ranks 0, 1, 2 have one material each" in reason_with(
        outcome, "with a material left out"
    )
    tree = to_tree(outcome.results[HARDNESS])
    assert set(tree["leave_one_material_out"]) == {"rank_regression"}
    assert tree["spectral_centroid"]["n"] == 3


# -- contacts ------------------------------------------------------------------------------


def test_too_little_quiet_for_the_svm_leaves_the_known_contacts(
    make_shore: Callable[..., Dataset], tmp_path: Path
) -> None:
    # 20 ms before the contact: enough for a window's baseline, not for a steady state.
    tree = whole_study(cut(make_shore(), 400, 900), tmp_path, "data", "contact detection", "blocks")
    assert tree["contact"]["windows_start_at"] == "known"
    assert "svm" not in tree["contact"]
    assert any("windows start at the known contacts" in reason for reason in tree["left_out"])
    assert tree["blocks"]["windows"]["with_window"] == 36


# -- hardly anything -----------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2])
def test_a_few_pinches(make_shore: Callable[..., Dataset], tmp_path: Path, count: int) -> None:
    tree = whole_study(make_shore().take(range(count)), tmp_path)
    assert tree["data"]["pinches"] == count
    assert ("sd" in tree["offset_ms"]) == (count > 1)


def test_no_window_at_all(make_shore: Callable[..., Dataset], ranks: Dataset) -> None:
    subject = Subject("x", cut(make_shore(), 0, 510))
    for outcome in (
        blocks(subject, SMALL, Serial(), MODELS),
        measure_objects(subject, SMALL, Serial(), MODELS),
        inference(subject, SMALL, Serial()),
        waveforms(subject),
        hardness(Subject("x", cut(ranks, 0, 510)), SMALL, Serial()),
    ):
        assert outcome.left_out
        assert set(to_tree(outcome.results)) <= {"blocks"}


def test_one_pinch_of_every_kind(make_shore: Callable[..., Dataset], ranks: Dataset) -> None:
    singles = make_shore(each=1, sessions=1)
    peaks = waveforms(Subject("x", singles)).results[PEAK]
    assert peaks["10"].sd is None
    assert detection_splits(singles.take([0]), 0) == []
    few = ranks.take(np.unique(ranks.objects, return_index=True)[1])
    order = hardness(Subject("x", few), SMALL, Serial()).results[HARDNESS]
    assert order.n_pinches == 6
    not_found = contacts(Subject("x", singles), SMALL, Serial()).results[CONTACT].about.not_found
    assert not_found.of == 3


# -- errors in a part ----------------------------------------------------------------------


def failing(error: Exception, shore: Dataset, out: Path, number: int = 2) -> None:
    steps = plan([("recordings", lambda: shore)], SMALL, Serial())[:4]

    def fail() -> PartResult:
        raise error

    steps[number] = replace(steps[number], run=fail)
    run_jobs(steps, study_state(SMALL, quick=True), out)


def test_input_that_a_part_cannot_use_leaves_that_part_out(shore: Dataset, tmp_path: Path) -> None:
    failing(InputError("pinch 7 is too short: record longer"), shore, tmp_path)
    tree = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert "Waveforms: pinch 7 is too short: record longer." in tree["left_out"]
    assert "blocks" in tree
    assert tree["study"]["complete"]


def test_data_that_cannot_be_read_end_the_study(shore: Dataset, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such thing"):
        failing(InputError("no such thing"), shore, tmp_path, number=0)
    assert not list(tmp_path.iterdir())


def test_an_error_of_ours_is_not_swallowed_and_the_page_says_so(
    shore: Dataset, tmp_path: Path
) -> None:
    with pytest.raises(ZeroDivisionError):
        failing(ZeroDivisionError("division by zero"), shore, tmp_path, number=1)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Stopped: recordings: contact detection: division by zero." in page
    assert "Still running" not in page
    tree = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert tree["study"]["stopped"].endswith("division by zero")
