"""What was measured of models in C stands in the docs as it was measured."""

from __future__ import annotations

import json
from pathlib import Path

import measure

DOCS = Path(__file__).parents[2] / "docs"
RESULTS = json.loads((DOCS / "results" / "embedded.json").read_text(encoding="utf-8"))


def test_the_page_has_the_table_of_the_results() -> None:
    page = (DOCS / "reference" / "embedded.md").read_text(encoding="utf-8")
    assert measure.table(RESULTS) in page


def test_c_was_the_model_of_python_wherever_it_was_asked() -> None:
    asked = [row for row in RESULTS["models"].values() if "asked" in row]
    assert sum(row["asked"] >= 1000 for row in asked) > 3
    for row in asked:
        assert row["class_mismatches"] == 0
        assert row["max_abs_error"] <= 0.01
        assert row["same_bytes"]
