"""Table of the time of an estimate: signal and computing, on the board and on this machine."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from firstcontact.core import InputError
from firstcontact_lab.study.parts.inference import board_table, read_board
from partial import results

FORM = {
    "estimator": "svm", "task": "regression", "samples": 75, "rate_hz": 5000.0,
    "instructions": 100_000,
}  # fmt: skip
HERE = {
    "p50": 40.0, "p99": 90.0, "p99_with_preempted": 95.0, "calls": 10, "preempted": 0,
    "load": 0.1, "cores": 2,
}  # fmt: skip


def file(folder: Path, models: dict[str, Any]) -> Path:
    path = folder / "embedded.json"
    path.write_text(json.dumps({"models": models, "peers": {}, "seeds": {"paper-rig": 31}}))
    return path


def cells(**result: Any) -> list[list[str]]:
    table = board_table(results(**result))
    assert table is not None
    return [[cell.text for cell in row.cells] for row in table.lines]


def test_samples_and_arithmetic_add_up_on_both_machines() -> None:
    computed = cells(board={"svr_10": FORM}, inference_us={"svm": HERE})
    # 75 samples at 5 kHz are 15 ms, 100,000 instructions at 1.5 cycles and 600 MHz 0.25 ms.
    assert computed == [["SVM", "75", "15.00 ms", "100,000", "250 µs", "15.25 ms", "15.09 ms"]]


def test_classifier_and_network_have_separate_times() -> None:
    classifier = {**FORM, "task": "classification"}
    network = {**FORM, "estimator": "in_context", "samples": 10}
    times = {"svm": {**HERE, "classification": {**HERE, "p99": 50.0}}}
    computed = cells(
        board={"svc": classifier, "running": network},
        inference_us=times,
        anytime_us={**HERE, "p99": 400.0},
    )
    assert [row[0] for row in computed] == ["SVM, classification", "In-context network"]
    assert [row[-1] for row in computed] == ["15.05 ms", "2.40 ms"]


def test_the_cheapest_and_the_dearest_form_are_displayed() -> None:
    board = {f"svr_{n}": {**FORM, "instructions": 1000 * n} for n in (20, 10, 40, 30)}
    assert [row[3] for row in cells(board=board)] == ["10,000", "40,000"]


def test_what_was_not_timed_here_has_no_time() -> None:
    assert cells(board={"a": FORM})[0][-1] == "15.25 ms"  # of the board, no column of this machine
    assert board_table(results(inference_us={"svm": HERE})) is None


def test_detectors_and_whole_models_are_no_answers(tmp_path: Path) -> None:
    path = file(tmp_path, {"a": FORM, "detector": {"instructions": 5}, "whole": {"blocks": 1.0}})
    assert list(read_board(path)) == ["a"]


@pytest.mark.parametrize(
    ("models", "kind"),
    [
        ({}, "no models whose instructions"),
        ({"a": {**FORM, "samples": 0}}, "models\\[...\\].samples is wrong"),
        ({"a": {**FORM, "instructions": "many"}}, "instructions is wrong"),
    ],
)
def test_another_file_is_refused(tmp_path: Path, models: dict[str, Any], kind: str) -> None:
    with pytest.raises(InputError, match=kind) as predictions:
        read_board(file(tmp_path, models))
    assert "make embedded" in str(predictions.value)
