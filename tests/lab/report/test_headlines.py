"""The first table lists the paper's claims with verdicts, and only measured numbers."""

from __future__ import annotations

import pytest

from firstcontact.models import Bounded
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Cell, Claim
from firstcontact_lab.study.outcome import outcome
from firstcontact_lab.study.page import claims, rows
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


def test_every_claim_has_a_verdict_whatever_its_unit() -> None:
    for row in rows({}):
        if row.claim is not None:
            assert row.claim.verdict(0.5 * row.claim.value, row.unit)


def test_both_models_stand_among_the_claims_and_nothing_that_is_missing() -> None:
    errors = {"svm": {"rmse": 9.0}, "cnn": {"rmse": 2.0}, "train_mean": {"rmse": 12.0}}
    result = verdicts(A=results(objects=errors))
    assert result == {
        "Unseen objects, SVM: RMSE": "worse by 4.83 Shore A",
        "Unseen objects, CNN: RMSE": "better by 0.39 Shore A",
    }
    assert verdicts(A=results()) == {}


def test_subjects_that_differ_are_named() -> None:
    good, bad = (results(objects={"svm": {"rmse": rmse}}) for rmse in (2.0, 9.0))
    assert list(verdicts(A=good, B=bad).values()) == [
        "a: better by 2.17 Shore A; b: worse by 4.83 Shore A"
    ]
    assert list(verdicts(A=good, B=good).values()) == ["better by 2.17 Shore A"]


def test_headlines_beyond_the_paper_follow_the_claims() -> None:
    result = results(
        objects={"svm": {"rmse": 9.0}},
        in_force={"share": 0.9, "rmse": 7.0},
        anytime={"asked": "objects", "rmse": {"5": 6.0}},
    )
    assert list(verdicts(A=result).values()) == ["worse by 4.83 Shore A", *["not in the paper"] * 3]


@pytest.mark.parametrize("busy", [{}, {"preempted": 5181, "calls": 100_000}, {"load": 8.2}])
def test_times_of_other_computers_are_never_called_better(busy: dict[str, float]) -> None:
    timed = {"p99": 90.0, "preempted": 0, "calls": 1000, "load": 1.0, "cores": 2}
    (verdict,) = verdicts(A=results(inference_us={"svm": timed | busy})).values()
    assert verdict.startswith("not comparable")
    assert ("busy" in verdict) == bool(busy)


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


def test_agreement_of_an_input_is_not_called_a_result() -> None:
    offset = {"mean": 16.6, "sd": 10.3, "share_below_15": 0.5}
    for source, expected in (("twin", "input of the twin"), ("real", "another hand")):
        result = verdicts(A=results(offset_ms=offset, data={"source": source}))
        assert set(result.values()) == {expected}


@pytest.mark.parametrize(
    ("means", "expected"),
    [
        ((0.1, 0.2, 0.4), "reproduced"),
        ((0.1, 0.14, 0.2), "rises with every level, but not in proportion"),
        ((0.1, 0.3, 0.2), "does not rise with every level"),
    ],
)
def test_the_peak_is_compared_with_proportion(means: tuple[float, ...], expected: str) -> None:
    peaks = {str(level): {"mean": m} for level, m in zip((10, 20, 40), means, strict=True)}
    assert list(verdicts(A=results(peak_v=peaks)).values()) == [expected]


def test_with_late_labels_rows_say_what_was_accepted() -> None:
    scores = {"window_accuracy": 0.98, "pinch_success": 1.0, "decided_within_3_ms": 0.5}
    subject = results(contact={"svm": scores, "early_ms": 4.0})
    labels = [row.label for row in rows({"A": subject})]
    assert not any("±3" in label for label in labels)
    assert "Contact, SVM: placed −7 to +3 ms from its label" in labels
    assert "Contact, SVM: and decided −4 to +3 ms from its label" in labels


def test_the_end_of_an_interval_is_not_rounded_up_to_all() -> None:
    scores = {"accuracy": 0.99, "n": 9, "intervals": {"accuracy": [0.9, 0.9997]}}
    subject = results(blocks={"svm": {"random_90_10": scores}})
    (line,) = claims({"A": subject}).lines
    assert line.cells[2] == Cell("99.0 %", "90.0 to 99.97")


def test_the_outcome_is_stated_for_each_subject_and_topic() -> None:
    def make(share: float, rmse: float) -> SubjectResults:
        splits = {
            "random_90_10": {"accuracy": share, "n": 9},
            "leave_one_shore_out": {"rmse": 16.9, "n": 9},
        }
        peak = {"leave_one_shore_out": {"rmse": 9.5, "n": 9}}
        best = {"leave_one_shore_out": {"rmse": 3.0, "n": 9}}
        return results(
            blocks={"svm": splits, "peak": peak, "log_spectrum": best},
            objects={"svm": {"rmse": rmse}},
            in_force={"share": 0.95},
        )

    blocks, unseen, time = outcome({"A": make(0.98, 6.4)})
    assert "as good as published (SVM 98.0 % against 97.2 %)" in blocks
    assert "worse than published (SVM 6.4 against 4.2)" in unseen
    assert "SVM 16.9, Peak amplitude 9.5, Log spectrum 3.0." in unseen
    assert "95.0 %" in time
    # Within the tolerance with which the row of this error is "reproduced".
    both = outcome({"A": make(0.98, 6.4), "B": make(0.9, 4.5)})
    assert "a as good as published (SVM 98.0 % against 97.2 %); b worse" in both[0]
    assert "a worse than published (SVM 6.4 against 4.2); b as good" in both[1]


def test_nothing_measured_is_no_outcome() -> None:
    assert outcome({"A": results()}) == []
    assert outcome({"A": results(in_force={"share": 0.5})}) == [
        "Pinches with an estimate ready when the second finger touches: 50.0 %."
    ]
