"""Remarks of the comparison agree with the numbers."""

from __future__ import annotations

import pytest

from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Cell
from firstcontact_lab.study.page import comparison
from partial import results


def remarks(*results: SubjectResults) -> dict[str, str]:
    """Return the remark of each row, for subjects A, B, ..."""
    subjects = dict(zip("AB", results, strict=False))
    return {line.cells[0].text: line.cells[-1].text for line in comparison(subjects).lines}


def remark(results: SubjectResults, label: str) -> str:
    return remarks(results)[label]


@pytest.mark.parametrize(
    ("rmse", "verdict"),
    [(9.0, "A: above both."), (3.0, "A: between."), (1.0, "A: below both.")],
)
def test_the_ambiguous_error_is_compared_both_ways(rmse: float, verdict: str) -> None:
    result = results(objects={"svm": {"rmse": rmse, "mae": rmse, "mse": rmse**2}})
    assert verdict in remark(result, "Unseen objects, SVM: RMSE")
    assert "2.04" in remark(result, "Unseen objects, SVM: RMSE")


@pytest.mark.parametrize(
    ("ends", "verdict"),
    [([0.96, 0.98], "inside"), ([0.98, 1.0], "below"), ([0.5, 0.9], "above")],
)
def test_the_published_accuracy_is_placed_against_the_interval(
    ends: list[float], verdict: str
) -> None:
    scores = {"accuracy": 0.97, "n": 250, "intervals": {"accuracy": ends}}
    result = results(blocks={"svm": {"random_90_10": scores}})
    assert f"A: {verdict}" in remark(result, "Blocks, SVM, random 90/10: accuracy")


def test_each_subject_is_judged_by_name() -> None:
    def make(ends: list[float], rmse: float) -> SubjectResults:
        scores = {"accuracy": 0.97, "n": 250, "intervals": {"accuracy": ends}}
        errors = {"rmse": rmse, "mae": rmse, "mse": rmse**2}
        return results(blocks={"svm": {"random_90_10": scores}}, objects={"svm": errors})

    both = remarks(make([0.96, 0.98], 9.0), make([0.5, 0.9], 3.0))
    interval = both["Blocks, SVM, random 90/10: accuracy"]
    assert "A: inside (250 test pinches); B: above" in interval
    assert "A: above both; B: between." in both["Unseen objects, SVM: RMSE"]


def test_the_accuracy_over_windows_says_what_silence_would_score() -> None:
    def make(windows: int, quiet: int) -> SubjectResults:
        scores = {"window_accuracy": 0.98, "windows": windows, "quiet_windows": quiet, "n": 10}
        return results(contact={"svm": scores})

    label = "Contact, SVM: windows right"
    assert "A: 97.6 %, B: 66.7 %" in remarks(make(410, 400), make(30, 20))[label]
    assert "never fires" not in remark(judged(0.98, 1.0, 2.0), label)


def test_with_late_labels_it_says_what_was_accepted() -> None:
    scores = {"window_accuracy": 0.98, "pinch_success": 1.0, "decided_within_3_ms": 0.5}
    contacts = results(contact={"svm": {**scores, "delay_ms": {"median": 2.0}}, "early_ms": 4.0})
    texts = remarks(contacts)
    assert not any("±3" in f"{label} {text}" for label, text in texts.items())
    placed = texts["Contact, SVM: placed −7 to +3 ms from its label"]
    assert "from 7 ms before its label" in placed
    decided = texts["Contact, SVM: and decided −4 to +3 ms from its label"]
    assert "from 4 ms before its label to 3 ms after it" in decided
    # The target is a stricter one than what is counted here: nothing is said to be reached.
    assert not any("arget" in text for text in texts.values())


def judged(windows: float, pinches: float, delay: float) -> SubjectResults:
    scores = {"window_accuracy": windows, "pinch_success": pinches, "delay_ms": {"median": delay}}
    return results(contact={"svm": scores})


DELAY = "Contact, SVM: median delay of the decision"


@pytest.mark.parametrize(
    ("scores", "verdict"),
    [
        ((0.9995, 0.998, 2.9), "A: reached."),
        ((0.9995, 0.99, 2.9), "A: not reached (pinches)."),
        ((0.9985, 0.998, 3.1), "A: not reached (windows, delay)."),
    ],
)
def test_the_target_has_three_parts(scores: tuple[float, float, float], verdict: str) -> None:
    assert verdict in remark(judged(*scores), DELAY)


def test_the_target_is_judged_where_it_could_be_and_named() -> None:
    met, missed = judged(1.0, 1.0, 2.0), judged(1.0, 0.9, 2.0)
    for result, verdict in (
        ([met, missed], "A: reached; B: not reached (pinches)."),
        ([met, results(data={})], ": A: reached."),
    ):
        assert verdict in remarks(*result)[DELAY]


def test_agreement_of_an_input_is_not_called_a_result() -> None:
    offset = {"mean": 16.6, "sd": 10.3, "share_below_15": 0.5}
    twin, real = (results(offset_ms=offset, data={"source": of}) for of in ("twin", "real"))
    assert "input of the twin" in remark(twin, "First to second contact, mean")
    assert "input" not in remark(real, "First to second contact, mean")


def test_missing_results_have_no_row() -> None:
    assert comparison({"A": results()}).lines == []


def test_the_end_of_an_interval_is_not_rounded_up_to_all() -> None:
    scores = {"accuracy": 0.99, "n": 9, "intervals": {"accuracy": [0.9, 0.9997]}}
    (line,) = comparison({"A": results(blocks={"svm": {"by_session": scores}})}).lines
    assert line.cells[2] == Cell("99.0 %", "90.0 to 99.97")
