"""Prose follows the results: no sentence holds for some data only and stands there for all."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from firstcontact.core import Dataset
from firstcontact_lab.report import _texts as texts
from firstcontact_lab.report._chapters import chapters
from firstcontact_lab.report._tables import block_table, data_table, hardness_table, length_table
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.data import describe
from partial import results


def starting(way: str, **more: Any) -> SubjectResults:
    return results(contact={"windows_start_at": way, **more})


@pytest.mark.parametrize(
    ("source", "kind", "row"),
    [
        ("twin", "Twin results", "the twin"),
        ("real", "Real recordings", "real recordings"),
        ("unknown", "Recordings of unknown origin", "not known"),
    ],
)
def test_only_what_is_said_to_be_real_is_called_real(source: str, kind: str, row: str) -> None:
    found = results(data={**DATA, "source": source})
    assert texts.kind([found]) == kind
    table = data_table(found)
    assert table is not None
    assert table.rows[0].cells[1].text.startswith(row)


def test_what_could_not_be_read_is_told_with_what_was_left_out(
    make_shore: Callable[..., Dataset],
) -> None:
    dataset = make_shore(each=2)
    loss = "left out, since it cannot be read: session-1.mcap is empty"
    damaged = replace(dataset, notes=("assumed", loss), losses=(loss,))
    outcome = describe(Subject("recordings", damaged))
    assert outcome.left_out[0] == f"{loss}."
    assert outcome.results.data is not None
    assert outcome.results.data.notes == ["assumed"]


def test_the_data_have_times_only_where_contacts_are_known() -> None:
    assert "when each finger" in texts.data([results(offset_ms={})])
    assert "when" not in texts.data([results(data={})])


@pytest.mark.parametrize(
    ("way", "said", "never"),
    [
        ("svm", "did not learn from it", "threshold fires"),
        ("three_sigma", "threshold fires", "did not learn from it"),
        ("known", "at the known contacts", "did not learn from it"),
    ],
)
def test_where_windows_start(way: str, said: str, never: str) -> None:
    text = texts.contact([starting(way)])
    assert said in text
    assert never not in text
    assert "scored" not in text
    assert "both are scored" in texts.contact([starting(way, three_sigma={"n": 3})])


def test_objects_are_counted() -> None:
    found = results(objects={"svm": {"over_objects": {"n": 34}}})
    assert "34 here" in texts.objects([found])
    assert "few" not in texts.objects([found])


def test_ranks_beside_shore_values_are_not_said_to_stand_alone() -> None:
    assert "No error in Shore A" in texts.hardness([results(hardness_order={})])
    assert "No error" not in texts.hardness([results(hardness_order={}, blocks={"svm": {}})])


def test_an_answer_before_the_second_contact_needs_second_contacts() -> None:
    assert "other finger" in texts.answer([results(answer_ms={"with_second": 3})])
    assert "other finger" not in texts.answer([results(answer_ms={"n": 3})])
    assert "label of the first" in texts.answer([starting("svm", early_ms=4.0)])


def test_what_the_detector_learned_from_is_said_where_it_learned() -> None:
    scores = {"rmse": 3.0, "mae": 2.0, "mse": 9.0, "bias": 0.0, "n": 9}
    left_out = {"leave_one_shore_out": scores}
    order = {
        "score": "s",
        "spectral_centroid": {"n": 3},
        "leave_one_material_out": {"rank_regression": {"n": 3}},
    }
    for way, learned in (("svm", True), ("known", False), ("three_sigma", False)):
        found = results(
            contact={"windows_start_at": way}, blocks={"svm": left_out}, hardness_order=order
        )
        table, ranks = block_table(found, "leave_one_shore_out"), hardness_table(found)
        assert table is not None
        assert ranks is not None
        for text in (table.caption, ranks.caption, texts.shared([found])):
            assert ("has learned from" in text) == learned


def test_the_searches_are_told_with_their_sizes() -> None:
    scores = {"rmse": 3.0, "mae": 2.0, "mse": 9.0}
    found = results(
        window_length_ms={"15": {"svm": {"blocks": scores}}}, window_length_search={"windows": 400}
    )
    table = length_table(found)
    assert table is not None
    assert "up to 400 windows here, on more elsewhere" in table.caption


def test_every_chapter_can_be_told_of_little() -> None:
    (chapter,) = chapters([Findings("recordings", results(data=DATA))])
    assert chapter.text == "What was touched."


DATA = {
    "source": "real", "pinches": 1, "train_pinches": 1, "test_pinches": 0, "specimens": 1,
    "sessions": 1, "sample_rate_hz": 4936.0,
}  # fmt: skip
