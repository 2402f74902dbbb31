"""The report: tables, rows, names and text that cannot be shown as it is."""

from collections.abc import Callable, Iterator
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from firstcontact.core import Dataset
from firstcontact.core.records import decode_by_name, to_tree
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.page import Column, Section, render
from firstcontact_lab.report.results import NOTHING, SubjectResults
from firstcontact_lab.report.tables import ABSENT, Cell, Line, Table, join_side_by_side
from firstcontact_lab.study.page import claims, read_study, rows
from firstcontact_lab.study.part import Subject
from firstcontact_lab.study.parts.contacts import contact_table
from firstcontact_lab.study.parts.hardness import hardness_figure
from firstcontact_lab.study.parts.inference import inference_table
from firstcontact_lab.study.set_scores import SetResults
from firstcontact_lab.study.sets import SET, sets_page
from partial import results, study_state, study_subject


def test_a_command_that_is_not_utf8_is_shown_all_the_same() -> None:
    state = study_state(command="firstcontact study --out \udcff", findings=[Findings("a")])
    assert r"study --out \udcff" in render(state)


def test_a_table_of_many_columns_does_not_stand_beside_another() -> None:
    narrow, broad = (Table("", ["x"] * columns, []) for columns in (5, 12))
    assert not Section("a", "A", "", details=[Column("one", [narrow], [])]).wide
    assert Section("a", "A", "", details=[Column("one", [narrow, broad], [])]).wide


def test_subjects_stand_side_by_side_line_by_line() -> None:
    def table(*names: tuple[str, str, str]) -> Table:
        return Table(
            "", ["", "x", "y"], [Line([Cell(a, b), Cell(c), Cell("-")]) for a, b, c in names]
        )

    both = {
        "A": table(("SVM", "3 vectors", "1"), ("CNN", "with", "2"), ("CNN", "without", "3")),
        "B": table(("SVM", "4 vectors", "4"), ("CNN", "without", "5")),
    }
    merged = join_side_by_side(both, ("x",))
    assert list(merged.head) == ["", "x, a", "x, b"]
    texts = [[cell.text for cell in line.cells] for line in merged.lines]
    assert texts == [["SVM", "1", "4"], ["CNN", "2", "–"], ["CNN", "3", "5"]]
    assert [list(join_side_by_side({"A": both["A"]}).head), len(merged.lines)] == [
        ["", "x", "y"],
        3,
    ]


def test_no_page_holds_a_control_character() -> None:
    hostile = "\x1b[31m\x1b]0;owned\x07\x9b2J\u202ec\x7f"
    entry = SetResults(
        n=1, sensor=hostile, rate_hz=5000.0, front_end=hostile, pinches=1, materials=1
    )
    findings = [Findings(f"set {hostile}", NOTHING.replace([SET(entry)]))]
    displayed = render(study_state(command=hostile, parts={}, page=sets_page, findings=findings))
    assert all(c in "\n\t" or c.isprintable() for c in displayed)
    assert displayed.count(r"\u001b[31m") == 4


SCORES = {
    "n": 10,
    "window_accuracy": 0.99,
    "pinch_success": 0.9,
    "decided_within_3_ms": 0.4,
    "delay_ms": {"median": 4.0, "p95": 5.0},
}


def texts(table: Table | None) -> dict[str, list[str]]:
    return {row.cells[0].text: [cell.text for cell in row.cells[1:]] for row in table.lines}


def test_late_labels_and_look_ahead_are_stated() -> None:
    contact = {"svm": {**SCORES, "lookahead_ms": 2.03}, "early_ms": 4.0}
    table = contact_table(results(contact=contact))
    assert "median delay of the decision after its label" in texts(table)
    assert "placed −7 to +3 ms from its label" in texts(table)
    assert "and decided −4 to +3 ms from its label" in texts(table)
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
    }
    tree = {"svm": {**entry, "support_vectors": 800, "classification": entry}, "cnn": entry}
    table = inference_table(results(inference_us=tree))
    assert list(texts(table)) == ["SVM", "SVM, classification", "CNN"]
    assert table.lines[0].cells[0].small == "800 support vectors; 3 calls preempted"
    assert [cell.text for cell in table.lines[0].cells[1:]] == ["5 µs", "9 µs"]
    assert "Load of the machine: 8.2 on 2 cores." in table.caption


RESULTS = Path(__file__).parents[3] / "docs" / "results"
#: Depth to which fields are left out.
DEPTH = 3


def cells(subject: SubjectResults, full: SubjectResults) -> dict[str, str]:
    """Return the number of a subject in each row that the full results have."""
    return {row.label: row.cell(subject).text for row in rows({"A": full})}


def without_one(tree: dict[str, Any], depth: int = DEPTH) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the tree without each of its fields in turn, and the name of the field.

    Points of a curve, whose names are numbers, stay together: rows describe whole curves.
    """
    for name, value in tree.items():
        if name.replace(".", "").isdigit():
            continue
        yield name, {key: rest for key, rest in tree.items() if key != name}
        if depth > 1 and isinstance(value, dict):
            for inner, less in without_one(value, depth - 1):
                yield f"{name}.{inner}", {**tree, name: less}


@pytest.mark.parametrize("file", ["study", "real", "strikes"])
def test_a_row_without_its_data_is_empty(file: str) -> None:
    full = read_study(RESULTS / f"{file}.json").about
    expected, kind = cells(full, full), study_subject()
    emptied: set[str] = set()
    for name, tree in without_one(to_tree(full)):
        try:
            subject = msgspec.convert(deepcopy(tree), kind, dec_hook=decode_by_name)
        except msgspec.ValidationError:
            continue  # the field is not optional
        for label, text in cells(subject, full).items():
            assert text in (expected[label], ABSENT), f"{label} without {name}"
            if text != expected[label]:
                emptied.add(label)
    assert emptied == {label for label, text in expected.items() if text != ABSENT}


def test_scores_of_blocks_are_no_scores_of_objects() -> None:
    scores = {"asked": "blocks", "rmse": {"3": 1.0, "5": 1.0, "15": 1.0}}
    subject = results(
        anytime={**scores, "others": {"network": {"asked": {"rmse": scores["rmse"]}}}}
    )
    texts = cells(subject, subject)
    assert {text for label, text in texts.items() if "objects" in label} == {ABSENT}
    assert claims({"A": subject}).lines == []


NAMES = [
    r"$\frac{$", "$x^2$", r"\alpha", "a\nb", "\x1b[31mred", "\x00", "x" * 200, "苹果苹果苹果苹果",
    "🍎" * 50, "<b>",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES, ids=ascii)
def test_objects_may_have_any_name(make_shore: Callable[..., Dataset], name: str) -> None:
    dataset = make_shore(each=4)
    pinches = tuple(
        replace(p, label=replace(p.label, object=name, specimen=name, hardness_rank=i % 3))
        for i, p in enumerate(dataset.pinches)
    )
    subject = Subject("a", replace(dataset, pinches=pinches))
    data = subject.windows(0.015)
    ranked = subject.labelled_windows(0.015, subject.dataset.hardness_rank)
    figure = hardness_figure(ranked, np.ones(len(data)))
    assert figure.image.startswith("data:image/svg+xml")
