"""Pages equal what their scripts write for the committed results."""

import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import taxels
import write_check
import write_household
import write_live
import write_out_of_range
import write_tables as numbers
import write_twin
from pages import ROOT, name

import forked
from firstcontact.core import InputError
from firstcontact.core.records import ByName, to_tree
from firstcontact.models.model_file import pretrained
from firstcontact.twin.household import ESTIMATE, HOLD, HOUSEHOLD, LIGHT, LOOSE_HOLD, SCATTER
from firstcontact_lab.grasping.judgement import FRICTIONS, LIMITS, MASSES
from firstcontact_lab.study.page import read_study
from partial import filled, study_subject


def write(path: Path, tree: dict[str, Any]) -> None:
    """Write the results of a study with all required fields."""
    kind = study_subject()
    path.write_text(json.dumps(filled(ByName[kind, kind], {"study": {}, **tree})))


STUDIES = (
    "study", "generalise", "random_rigs", "closing_speed", "real", "strikes", "grasp", "sets"
)  # fmt: skip


@pytest.mark.parametrize("result", STUDIES)
def test_committed_results_are_read_whole_and_written_as_they_are(result: str) -> None:
    path = numbers.RESULTS / f"{result}.json"
    again = json.loads(json.dumps(to_tree(read_study(path))))
    assert again == json.loads(path.read_text(encoding="utf-8"))


def test_a_field_that_no_record_has_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "study.json", {"contact": {"svm": {}}})
    tree = json.loads((tmp_path / "study.json").read_text())
    tree["contact"]["svm"]["accuracy_of_windows"] = 1.0
    (tmp_path / "study.json").write_text(json.dumps(tree))
    with pytest.raises(InputError, match="accuracy_of_windows"):
        numbers.tables(tmp_path)


@pytest.mark.parametrize(
    "script", [taxels, write_check, write_household, write_live, write_twin, write_out_of_range]
)
def test_a_page_has_the_tables_of_its_script(script: ModuleType) -> None:
    text = script.PAGE.read_text(encoding="utf-8")
    assert script.filled(text) == text, f"run {script.__file__}"


@pytest.mark.parametrize("page", numbers.pages(ROOT), ids=name)
def test_tables_agree_with_the_committed_results(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert numbers.filled(text, numbers.tables(numbers.RESULTS)) == text, "make readme-numbers"


def test_a_table_has_the_values_of_its_results(tmp_path: Path) -> None:
    condition = {"offset_ms": {"mean": 16.5}, "contact": {"svm": {"window_accuracy": 0.9987}}}
    study = {
        **condition,
        "study": {"condition": "paper-rig"},
        "everyday": {"offset_ms": {"mean": 17.25}},
        "seconds": 600.4,
    }
    write(tmp_path / "study.json", study)
    made = numbers.tables(tmp_path)
    assert "| | published | paper rig | everyday |" in made["study"].replace("|  |", "| |")
    assert "| First to second contact, mean | 16.65 ms | 16.50 ms | 17.25 ms |" in made["study"]
    assert "| Contact, SVM: windows right | 100.0 % | 99.9 % | – |" in made["study"]
    assert "CNN" not in made["study"]
    assert "| The whole study | – | 600 s | – |" in made["speed"]
    assert made["real"] == "*Not run yet.*\n"


LATE = {"pinch_success": 1.0, "decided_within_3_ms": 0.25, "delay_ms": {"median": 2.0}}
INTERVAL = {"accuracy": 0.5, "rmse": 3.0, "intervals": {"accuracy": [0.41, 0.622]}}


@pytest.mark.parametrize(
    ("table", "tree", "lines"),
    [
        (
            "speed",
            {
                "inference_us": {"svm": {"p50": 20.0, "classification": {"p99": 63.0}}},
                "everyday": {"inference_us": {"svm": {"p50": 31.0}}},
            },
            [
                "SVM, one window: median | – | 20 µs | 31 µs",
                "SVM classifier, one window: p99 | – | 63 µs | –",
            ],
        ),
        (
            "real",
            {"contact": {"svm": LATE, "early_ms": 4.0}},
            [
                "Contact, SVM: placed −7 to +3 ms from its label | 100.0 %",
                "Contact, SVM: and decided −4 to +3 ms from its label | 25.0 %",
            ],
        ),
        (
            "study",
            {"blocks": {"svm": {"by_session": INTERVAL}}},
            [
                "Blocks, SVM, by session: accuracy | – | 50.0 % (41.0 to 62.2)",
                "Blocks, SVM, by session: RMSE | – | 3.00",
            ],
        ),
        (  # a share is not rounded up to all
            "study",
            {"contact": {"svm": {"window_accuracy": 0.99964}}},
            ["Contact, SVM: windows right | 100.0 % | 99.96 %"],
        ),
    ],
)
def test_a_line_has_the_value_and_what_belongs_to_it(
    table: str, tree: dict[str, Any], lines: list[str], tmp_path: Path
) -> None:
    write(tmp_path / ("real.json" if table == "real" else "study.json"), tree)
    made = numbers.tables(tmp_path)[table].splitlines()
    assert {f"| {line} |" for line in lines} <= set(made)


def test_the_page_is_what_help_prints(tmp_path: Path) -> None:
    page_text = (ROOT / "docs/reference/cli.md").read_text(encoding="utf-8")
    (tmp_path / "now.md").write_text(page_text, encoding="utf-8")
    code = (
        "import help_of_docs, pathlib; now = pathlib.Path('now.md'); "
        "now.write_text(help_of_docs.page(now.read_text()))"
    )
    (tmp_path / "help_of_docs.py").write_text(
        (ROOT / "docs/write_cli.py").read_text(encoding="utf-8")
    )
    assert forked.run("code", code, cwd=tmp_path).returncode == 0
    now = (tmp_path / "now.md").read_text(encoding="utf-8")
    assert page_text == now, "python docs/write_cli.py"


def test_every_number_has_a_listed_source() -> None:
    used = {
        quantity.source
        for item in HOUSEHOLD
        for name in write_household.SHOWN
        if (quantity := getattr(item.numbers, name)) is not None
    }
    assert used - {ESTIMATE} == {source["key"] for source in write_household.SOURCES}


def test_its_scatters_and_variations_are_those_of_the_code() -> None:
    text = (ROOT / "docs/reference/twin-parameters.md").read_text(encoding="utf-8")
    for origin, scatter in SCATTER.items():
        numbers = (scatter.modulus, scatter.mass, scatter.friction)
        assert f"| {origin} | " + " | ".join(f"{n:g}" for n in numbers) + " |" in text
    for kind, factors in (("limits", LIMITS), ("masses", MASSES), ("frictions", FRICTIONS)):
        for factor in factors:
            assert f"`{kind} × {factor:g}`" in text
    held_out = f"{LOOSE_HOLD[0]:g} N/m and {LOOSE_HOLD[1]:g} N s/m below {1e3 * LIGHT:g} g"
    assert held_out in text
    assert f"{HOLD[0]:g} N/m and {HOLD[1]:g} N s/m" in text


@pytest.mark.parametrize("name", ["sine of 300 Hz", "noise that begins", "step"])
def test_a_row_is_printed_as_written(name: str) -> None:
    row = json.loads(write_out_of_range.RESULTS.read_text(encoding="utf-8"))["others"][name]
    touches = write_out_of_range.made_up(write_out_of_range.MADE_UP[name])
    assert len(touches) == row["n"]
    computed = write_out_of_range.count_out_of_range(pretrained(), touches) / len(touches)
    np.testing.assert_allclose(computed, row["no_rig"], atol=0.01)


def test_touches_are_rarely_out_of_range_and_most_other_signals_are() -> None:
    rows = json.loads(write_out_of_range.RESULTS.read_text(encoding="utf-8"))
    for labelled_contacts in ("rig", "no_rig"):
        assert max(rows["touches"]["random rigs, as trained on"][labelled_contacts]) < 0.03
        remaining = [np.mean(row[labelled_contacts]) for row in rows["others"].values()]
        assert np.median(remaining) > 0.95
