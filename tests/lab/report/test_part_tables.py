"""Tables of the report, from results with known content."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from firstcontact.core import InputError
from firstcontact_lab.report.tables import Table
from firstcontact_lab.study.parts.contacts import contact_table
from firstcontact_lab.study.parts.inference import board_table, inference_table, read_board
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


SCORES = {
    "n": 10,
    "window_accuracy": 0.99,
    "pinch_success": 0.9,
    "decided_within_3_ms": 0.4,
    "delay_ms": {"median": 4.0, "p95": 5.0},
}


def texts(table: Table | None) -> dict[str, list[str]]:
    assert table is not None
    return {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in table.lines}


def test_late_labels_and_look_ahead_are_stated() -> None:
    contact = {"svm": {**SCORES, "lookahead_ms": 2.03}, "early_ms": 4.0}
    table = contact_table(results(contact=contact))
    assert "median delay of the decision after its label" in texts(table)
    assert "placed −7 to +3 ms from its label" in texts(table)
    assert "and decided −4 to +3 ms from its label" in texts(table)
    assert table is not None
    assert "±3" not in " ".join(c.text + c.small for row in table.lines for c in row.cells)
    assert "up to 4 ms late" in table.caption
    assert "2.0 ms of the resampler" in table.caption


def test_every_timed_model_has_a_row() -> None:
    entry = {
        "p50": 5.0,
        "p99": 9.0,
        "calls": 100,
        "preempted": 3,
        "p99_with_preempted": 4200.0,
        "load": 8.25,
        "cores": 2,
        "reference": "scikit-learn",
        "reference_p50": 50.0,
        "speedup": 10.0,
    }
    tree = {"svm": {**entry, "support_vectors": 800, "classification": entry}, "cnn": entry}
    table = inference_table(results(inference_us=tree))
    assert list(texts(table)) == ["SVM", "SVM, classification", "CNN"]
    assert table is not None
    assert table.lines[0].cells[0].small == "800 support vectors; 3 calls preempted; scikit-learn"
    assert [cell.text for cell in table.lines[0].cells[1:]] == ["5 µs", "9 µs", "10.0 ×"]
    assert "Load of the machine: 8.2 on 2 cores." in table.caption
