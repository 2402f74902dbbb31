"""The docs repeat the measured costs of models in C."""

import json
from pathlib import Path

import measure

DOCS = Path(__file__).parents[2] / "docs"
RESULTS = json.loads((DOCS / "results" / "embedded.json").read_text(encoding="utf-8"))


def test_the_pages_have_the_tables_of_the_results() -> None:
    for page in measure.PAGES:
        text = page.read_text(encoding="utf-8")
        assert measure.fill(text, "embedded", measure.tables(RESULTS)) == text


def test_the_page_says_what_the_chain_takes() -> None:
    page = (DOCS / "reference" / "embedded.md").read_text(encoding="utf-8")
    for name in ("chain_sample", "chain_costliest", "chain_first", "chain_25", "chain_74"):
        assert f"{RESULTS['models'][name]['instructions']:,}" in page


def test_most_estimates_are_in_time_on_the_hand() -> None:
    for row in RESULTS["in_time"].values():
        assert row["closings"] >= 1000
        assert row["any"] >= 0.99 * row["instant"]


def test_c_equals_python_at_every_query() -> None:
    requests = [row for row in RESULTS["models"].values() if "asked" in row]
    assert sum(row["asked"] >= 1000 for row in requests) > 3
    for row in requests:
        assert row["class_mismatches"] == 0
        assert row["max_abs_error"] <= 0.01
        assert row["same_bytes"]


def test_the_budgets_of_the_hand_are_preserved() -> None:
    """The docs state the costs of the default export."""
    models = RESULTS["models"]
    assert all(models[name]["instructions"] <= 120_000 for name in models if name[:3] == "svr")
    assert models["chain_costliest"]["instructions"] <= 200_000  # 0.5 ms
    assert models["chain_74"]["flash"] <= 300_000  # program and image
    assert models["chain_74"]["ram"] <= 64_000
