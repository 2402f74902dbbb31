"""Tables of the report, from results with known content."""

from firstcontact_lab.report.tables import Table
from firstcontact_lab.study.parts.contacts import contact_table
from firstcontact_lab.study.parts.inference import inference_table
from partial import results

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
