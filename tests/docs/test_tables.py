"""Tables in the pages equal the script's output for the committed results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import write_tables as numbers
from pages import ROOT, name

from firstcontact.core import InputError
from firstcontact.core.records import ByName, to_tree
from firstcontact_lab.study.page import read_study
from partial import filled, study_subject


def write(path: Path, tree: dict[str, Any]) -> None:
    """Write the results of a study with all required fields."""
    kind = study_subject()
    path.write_text(json.dumps(filled(ByName[kind, kind], {"study": {}, **tree})))


@pytest.mark.parametrize(
    "result",
    [
        "study",
        "generalise",
        "random_rigs",
        "closing_speed",
        "real",
        "strikes",
        "grasp",
        "sets",
    ],
)
def test_committed_results_are_read_whole_and_written_as_they_are(result: str) -> None:
    path = numbers.RESULTS / f"{result}.json"
    again = json.loads(json.dumps(to_tree(read_study(path))))
    assert again == json.loads(path.read_text(encoding="utf-8"))


def test_there_are_no_other_results() -> None:
    assert {p.name for p in numbers.RESULTS.iterdir()} == {
        "study.json",
        "generalise.json",
        "random_rigs.json",
        "closing_speed.json",
        "real.json",
        "strikes.json",
        "grasp.json",
        "sets.json",
        "live.json",  # of benchmarks/live.py, which the study reads
        "benchmarks.json",  # of benchmarks/run.py
        "check.json",  # of docs/write_check.py
        "circuit.json",  # of hardware/write_page.py
        "embedded.json",  # of firmware/measure: tests/export holds its table against it
        "out_of_range.json",  # of docs/write_out_of_range.py: test_out_of_range.py holds it
    }


def test_a_field_that_no_record_has_is_refused(tmp_path: Path) -> None:
    write(tmp_path / "study.json", {"contact": {"svm": {}}})
    tree = json.loads((tmp_path / "study.json").read_text())
    tree["contact"]["svm"]["accuracy_of_windows"] = 1.0
    (tmp_path / "study.json").write_text(json.dumps(tree))
    with pytest.raises(InputError, match="accuracy_of_windows"):
        numbers.tables(tmp_path)


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


def test_speed_has_both_conditions_and_the_classifier(tmp_path: Path) -> None:
    svm = {"p50": 20.0, "classification": {"p99": 63.0, "speedup": 9.1}}
    study = {"inference_us": {"svm": svm}, "everyday": {"inference_us": {"svm": {"p50": 31.0}}}}
    write(tmp_path / "study.json", study)
    made = numbers.tables(tmp_path)["speed"]
    assert "| SVM, one window: median | – | 20 µs | 31 µs |" in made
    assert "| SVM classifier, one window: p99 | – | 63 µs | – |" in made
    assert (
        "| SVM classifier, one window: faster than its training library | – | 9.1 × | – |" in made
    )


def test_contact_windows_stand_beside_all_windows(tmp_path: Path) -> None:
    svm = {"window_accuracy": 0.976, "contact_windows_found": 0.0}
    write(tmp_path / "study.json", {"contact": {"svm": svm}})
    lines = numbers.tables(tmp_path)["study"].splitlines()
    at = lines.index("| Contact, SVM: windows right | 100.0 % | 97.6 % |")
    assert lines[at + 1] == "| Contact, SVM: contact windows found | – | 0.0 % |"


def test_late_labels_are_stated(tmp_path: Path) -> None:
    svm = {"pinch_success": 1.0, "decided_within_3_ms": 0.25, "delay_ms": {"median": 2.0}}
    real = {"contact": {"svm": svm, "early_ms": 4.0}}
    write(tmp_path / "real.json", real)
    made = numbers.tables(tmp_path)["real"]
    assert "| Contact, SVM: placed −7 to +3 ms from its label | 100.0 % |" in made
    assert "| Contact, SVM: and decided −4 to +3 ms from its label | 25.0 % |" in made
    assert "| Contact, SVM: median delay of the decision after its label | 2.00 ms |" in made


def test_an_interval_stands_beside_its_value(tmp_path: Path) -> None:
    scores = {"accuracy": 0.5, "rmse": 3.0, "intervals": {"accuracy": [0.41, 0.622]}}
    study = {"blocks": {"svm": {"by_session": scores}}}
    write(tmp_path / "study.json", study)
    made = numbers.tables(tmp_path)["study"]
    assert "| Blocks, SVM, by session: accuracy | – | 50.0 % (41.0 to 62.2) |" in made
    assert "| Blocks, SVM, by session: RMSE | – | 3.00 |" in made


def test_a_share_is_not_rounded_up_to_all(tmp_path: Path) -> None:
    study = {"contact": {"svm": {"window_accuracy": 0.99964}}}
    write(tmp_path / "study.json", study)
    made = numbers.tables(tmp_path)["study"]
    assert "| Contact, SVM: windows right | 100.0 % | 99.96 % |" in made


def test_filling_twice_changes_nothing(tmp_path: Path) -> None:
    made = numbers.tables(tmp_path)
    text = "a\n\n<!-- numbers: study -->\n<!-- /numbers -->\n\nb\n"
    once = numbers.filled(text, made)
    assert "Not run yet" in once
    assert numbers.filled(once, made) == once
