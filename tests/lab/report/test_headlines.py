"""Claims, verdicts and texts of the report follow from the results."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from firstcontact.core import Dataset
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Bounded, Claim, Row
from firstcontact_lab.study.page import claims, outcome, shared
from firstcontact_lab.study.part import Subject
from firstcontact_lab.study.parts.blocks import block_table
from firstcontact_lab.study.parts.data import DATA as DATA_FIELD
from firstcontact_lab.study.parts.data import data_table, describe, kind
from firstcontact_lab.study.parts.hardness import class_table
from partial import results


def verdicts(**subjects: SubjectResults) -> dict[str, str]:
    """Return the verdict of each claim."""
    return {line.cells[0].text: line.cells[-1].text for line in claims(subjects).lines}


SHARE = Claim(0.9, tolerance=0.02)
ERROR = Claim(4.0, tolerance=0.4, lower=True)


@pytest.mark.parametrize(
    ("claim", "unit", "value", "verdict"),
    [
        (SHARE, "share", Bounded(0.915, (0.88, 0.97)), "reproduced"),
        (SHARE, "share", Bounded(0.915, (0.91, 0.92)), "reproduced"),
        (SHARE, "share", 0.885, "reproduced"),
        (SHARE, "share", Bounded(0.95, (0.88, 0.97)), "better by 5.0 points, not excluded"),
        (SHARE, "share", Bounded(0.95, (0.92, 0.97)), "better by 5.0 points"),
        (SHARE, "share", 0.93, "better by 3.0 points"),
        (SHARE, "share", Bounded(0.85, (0.8, 0.87)), "worse by 5.0 points"),
        (ERROR, "shore", Bounded(6.25, (3.9, 8.2)), "worse by 2.25 Shore A, not excluded"),
        (ERROR, "shore", Bounded(6.25, (4.5, 8.2)), "worse by 2.25 Shore A"),
        (ERROR, "shore", Bounded(3.0, (2.5, 3.5)), "better by 1.00 Shore A"),
        (ERROR, "shore", 4.25, "reproduced"),
        (SHARE, "share", None, ""),
    ],
)
def test_a_verdict_states_the_difference_and_whether_the_interval_includes_the_claim(
    claim: Claim, unit: str, value: Bounded | float | None, verdict: str
) -> None:
    assert claim.verdict(value, unit) == verdict


def test_subjects_that_differ_are_named() -> None:
    good, bad = (results(objects={"svm": {"rmse": rmse}}) for rmse in (2.0, 9.0))
    assert list(verdicts(A=good, B=bad).values()) == [
        "a: better by 2.17 Shore A; b: worse by 4.83 Shore A"
    ]
    assert list(verdicts(A=good, B=good).values()) == ["better by 2.17 Shore A"]


@pytest.mark.parametrize("busy", [{}, {"preempted": 5181, "calls": 100_000}, {"load": 8.2}])
def test_times_of_other_computers_are_not_among_the_claims(busy: dict[str, float]) -> None:
    timed = {"p99": 90.0, "preempted": 0, "calls": 1000, "load": 1.0, "cores": 2}
    assert not verdicts(A=results(inference_us={"svm": timed | busy}))


def windows(share: float, count: int, quiet: int) -> SubjectResults:
    scores = {"window_accuracy": share, "windows": count, "quiet_windows": quiet, "n": 10}
    return results(contact={"three_sigma": scores})


def test_the_verdict_on_detection_says_what_silence_would_score() -> None:
    (verdict,) = verdicts(A=windows(0.91, 410, 400)).values()
    assert verdict.startswith("reproduced. ")
    assert "97.6 %" in verdict
    (both,) = verdicts(A=windows(0.91, 410, 400), B=windows(0.5, 30, 20)).values()
    assert "A: a detector that never fires: 97.6 %; b: a detector that never fires: 66.7 %" in both
    (unknown,) = verdicts(A=windows(0.91, 0, 0)).values()
    assert unknown == "reproduced"


def test_the_outcome_is_stated_for_each_subject_and_topic() -> None:
    def make(share: float, rmse: float) -> SubjectResults:
        left_out = {"svm": 16.9, "peak": 9.5, "log_spectrum": 3.0}
        blocks = {n: {"leave_one_shore_out": {"rmse": e, "n": 9}} for n, e in left_out.items()}
        blocks["svm"]["random_90_10"] = {"accuracy": share, "n": 9}
        return results(blocks=blocks, objects={"svm": {"rmse": rmse}}, in_force={"share": 0.95})

    blocks, unseen, time = outcome({"A": make(0.98, 6.4)})
    assert "as good as published (SVM 98.0 % against 97.2 %)" in blocks
    assert "worse than published (SVM 6.4 against 4.2)" in unseen
    assert "SVM 16.9, Peak amplitude 9.5, Log spectrum 3.0." in unseen
    assert "95.0 %" in time
    # Within the tolerance with which the row of this error is "reproduced".
    both = outcome({"A": make(0.98, 6.4), "B": make(0.9, 4.5)})
    assert "a as good as published (SVM 98.0 % against 97.2 %); b worse" in both[0]
    assert "a worse than published (SVM 6.4 against 4.2); b as good" in both[1]


def test_what_was_not_measured_has_no_sentence() -> None:
    assert outcome({"A": results()}) == []
    (ready,) = outcome({"A": results(in_force={"share": 0.5})})
    assert "50.0 %" in ready


DATA = {
    "source": "real", "pinches": 1, "train_pinches": 1, "test_pinches": 0, "specimens": 1,
    "sessions": 1, "sample_rate_hz": 4936.0,
}  # fmt: skip


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
    assert table.lines[0].cells[1].text.startswith(row)


def test_unreadable_files_are_left_out_with_the_reason(make_shore: Callable[..., Dataset]) -> None:
    dataset = make_shore(each=2)
    loss = "left out, since it cannot be read: session-1.mcap is empty"
    damaged = replace(dataset, notes=("assumed", loss), losses=(loss,))
    outcome = describe(Subject("recordings", damaged))
    assert outcome.left_out[0] == f"{loss}."
    data = outcome.results[DATA_FIELD]
    assert data.notes == ["assumed"]


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
        for caption in (levels.caption, classes_table.caption, shared({"A": contacts})):
            assert ("detector that places the windows" in caption) == learned
