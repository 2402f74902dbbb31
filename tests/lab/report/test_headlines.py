"""The first table lists the paper's claims with verdicts, and only measured numbers."""

from __future__ import annotations

import pytest

from firstcontact.models import Bounded
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Claim
from firstcontact_lab.study.page import claims
from partial import results


def verdicts(**subjects: SubjectResults) -> dict[str, str]:
    """Return the verdict of each claim."""
    return {line.cells[0].text: line.cells[-1].text for line in claims(subjects).lines}


@pytest.mark.parametrize(
    ("claim", "value", "verdict"),
    [
        (Claim(0.9), Bounded(0.95, (0.88, 0.97)), "reproduced"),
        (Claim(0.9), Bounded(0.95, (0.92, 0.97)), "better"),
        (Claim(0.9), Bounded(0.85, (0.8, 0.87)), "worse"),
        (Claim(4.0, lower=True), Bounded(5.0, (4.5, 6.0)), "worse"),
        (Claim(4.0, lower=True), Bounded(3.0, (2.5, 3.5)), "better"),
        (Claim(0.9, tolerance=0.02), 0.915, "reproduced"),
        (Claim(0.9, tolerance=0.02), 0.93, "better"),
        (Claim(16.65, note="input of the twin"), 16.0, "input of the twin"),
        (Claim(1.0), None, ""),
    ],
)
def test_a_verdict_compares_with_the_interval(
    claim: Claim, value: Bounded | float | None, verdict: str
) -> None:
    assert claim.verdict(value) == verdict


def test_both_models_stand_among_the_claims_and_nothing_that_is_missing() -> None:
    errors = {"svm": {"rmse": 9.0}, "cnn": {"rmse": 2.0}, "train_mean": {"rmse": 12.0}}
    result = verdicts(A=results(objects=errors))
    assert result == {"Unseen objects, SVM: RMSE": "worse", "Unseen objects, CNN: RMSE": "better"}
    assert verdicts(A=results()) == {}


def test_subjects_that_differ_are_named() -> None:
    good, bad = (results(objects={"svm": {"rmse": rmse}}) for rmse in (2.0, 9.0))
    assert list(verdicts(A=good, B=bad).values()) == ["a better; b worse"]
    assert list(verdicts(A=good, B=good).values()) == ["better"]


def test_headlines_beyond_the_paper_follow_the_claims() -> None:
    result = results(
        objects={"svm": {"rmse": 9.0}},
        in_force={"share": 0.9, "rmse": 7.0},
        anytime={"rmse": {"5": 6.0}},
    )
    assert list(verdicts(A=result).values()) == ["worse", *["not in the paper"] * 3]


@pytest.mark.parametrize("busy", [{"preempted": 5181, "calls": 100_000}, {"load": 8.2}])
def test_a_busy_machine_has_no_verdict_on_its_time(busy: dict[str, float]) -> None:
    timed = {"p99": 90.0, "preempted": 0, "calls": 1000, "load": 1.0, "cores": 2}
    assert verdicts(A=results(inference_us={"svm": timed})) == {"SVM, one window: p99": "better"}
    (verdict,) = verdicts(A=results(inference_us={"svm": timed | busy})).values()
    assert verdict != "better"
