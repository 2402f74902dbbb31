"""The first table lists the paper's claims with verdicts, and only measured numbers."""

from __future__ import annotations

import pytest

from firstcontact.models import Bounded
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Claim
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
        (Claim(1000.0, lower=True), "us", 21.0, "better"),
        (Claim(1000.0, lower=True), "us", 1100.0, "worse"),
        (Claim(16.65, note="input of the twin"), "ms", 16.0, "input of the twin"),
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
        "a better by 2.17 Shore A; b worse by 4.83 Shore A"
    ]
    assert list(verdicts(A=good, B=good).values()) == ["better by 2.17 Shore A"]


def test_headlines_beyond_the_paper_follow_the_claims() -> None:
    result = results(
        objects={"svm": {"rmse": 9.0}},
        in_force={"share": 0.9, "rmse": 7.0},
        anytime={"rmse": {"5": 6.0}},
    )
    assert list(verdicts(A=result).values()) == ["worse by 4.83 Shore A", *["not in the paper"] * 3]


@pytest.mark.parametrize("busy", [{"preempted": 5181, "calls": 100_000}, {"load": 8.2}])
def test_a_busy_machine_has_no_verdict_on_its_time(busy: dict[str, float]) -> None:
    timed = {"p99": 90.0, "preempted": 0, "calls": 1000, "load": 1.0, "cores": 2}
    assert verdicts(A=results(inference_us={"svm": timed})) == {"SVM, one window: p99": "better"}
    (verdict,) = verdicts(A=results(inference_us={"svm": timed | busy})).values()
    assert verdict != "better"
