"""A row never shows a number of other data than its label says."""

from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import msgspec
import pytest

from firstcontact.core.records import decode_by_name, to_tree
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import ABSENT
from firstcontact_lab.study.page import claims, read_study, rows
from partial import results, study_subject

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
