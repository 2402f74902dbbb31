"""Text of the report follows from the results, for any data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from firstcontact.core import Dataset
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Row
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.page import sections, shared
from firstcontact_lab.study.parts import PARTS
from firstcontact_lab.study.parts.blocks import block_table
from firstcontact_lab.study.parts.data import DATA as DATA_FIELD
from firstcontact_lab.study.parts.data import data_table, describe, kind
from firstcontact_lab.study.parts.hardness import class_table
from firstcontact_lab.study.parts.window_length import length_table
from partial import results

DATA = {
    "source": "real", "pinches": 1, "train_pinches": 1, "test_pinches": 0, "specimens": 1,
    "sessions": 1, "sample_rate_hz": 4936.0,
}  # fmt: skip


def text(part: str, results: SubjectResults) -> str:
    """Return the text of a section for one subject."""
    return PARTS[part].text({"A": results})


def starting(route: str, **more: Any) -> SubjectResults:
    return results(contact={"windows_start_at": route, **more})


@pytest.mark.parametrize(
    ("source", "badge", "row"),
    [
        ("twin", "Twin results", "the twin"),
        ("real", "Real recordings", "real recordings"),
        ("unknown", "Recordings of unknown origin", "unknown"),
    ],
)
def test_only_recordings_with_a_real_source_are_called_real(
    source: str, badge: str, row: str
) -> None:
    result = results(data={**DATA, "source": source})
    assert kind({"A": result}) == badge
    table = data_table(result)
    assert table is not None
    assert table.lines[0].cells[1].text.startswith(row)


def test_unreadable_files_are_left_out_with_the_reason(make_shore: Callable[..., Dataset]) -> None:
    dataset = make_shore(each=2)
    loss = "left out, since it cannot be read: session-1.mcap is empty"
    damaged = replace(dataset, notes=("assumed", loss), losses=(loss,))
    outcome = describe(Subject("recordings", damaged))
    assert outcome.left_out[0] == f"{loss}."
    data = outcome.results[DATA_FIELD]
    assert data is not None
    assert data.notes == ["assumed"]


@pytest.mark.parametrize(
    ("route", "expected", "never"),
    [
        ("svm", "trained on other pinches", "needs no training"),
        ("three_sigma", "needs no training", "trained on other"),
        ("known", "at the known contacts", "trained on other"),
    ],
)
def test_the_start_of_windows_is_explained(route: str, expected: str, never: str) -> None:
    section = text("contacts", starting(route))
    assert expected in section
    assert never not in section


def test_ranks_beside_shore_values_do_not_stand_alone() -> None:
    assert "no errors in Shore A" in text("hardness", results(hardness_order={}))
    both = results(hardness_order={}, blocks={"svm": {}})
    assert "no errors" not in text("hardness", both)


def test_an_answer_before_the_second_contact_needs_second_contacts() -> None:
    assert "other finger" in text("answer_time", results(answer_ms={"with_second": 3}))
    assert "other finger" not in text("answer_time", results(answer_ms={"n": 3}))
    assert "label of the first" in text("answer_time", starting("svm", early_ms=4.0))


def test_the_training_data_of_the_detector_are_named_where_it_learned() -> None:
    scores = {"rmse": 3.0, "mae": 2.0, "mse": 9.0, "bias": 0.0, "n": 9}
    left_out = {"leave_one_shore_out": scores}
    classes = {"svm": {"accuracy": 1.0, "n": 2, "classes": [0.0], "confusion": [[2]]}}
    order = {
        "score": "s",
        "spectral_centroid": {"n": 3},
        "leave_one_material_out": {"classification": classes},
    }
    for route, learned in (("svm", True), ("known", False), ("three_sigma", False)):
        contacts = results(
            contact={"windows_start_at": route}, blocks={"svm": left_out}, hardness_order=order
        )
        levels, classes_table = (
            block_table(contacts, "leave_one_shore_out", (Row("RMSE", lambda s: s.rmse),)),
            class_table(contacts),
        )
        assert levels is not None
        assert classes_table is not None
        for caption in (levels.caption, classes_table.caption, shared({"A": contacts})):
            assert ("detector that places the windows" in caption) == learned


def test_the_size_of_the_search_is_in_the_caption() -> None:
    scores = {"rmse": 3.0, "mae": 2.0, "mse": 9.0}
    result = results(
        window_length_ms={"15": {"svm": {"blocks": scores}}}, window_length_search={"windows": 400}
    )
    table = length_table(result)
    assert table is not None
    assert "400" in table.caption
    assert "400" not in PARTS["window_length"].title


def test_a_section_needs_the_results_of_its_part_only() -> None:
    (section,) = sections([Findings("recordings", results(data=DATA))])
    assert section.anchor == "data"
