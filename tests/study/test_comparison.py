"""Remarks follow the numbers."""

from __future__ import annotations

import pytest

from firstcontact.study.comparison import compare, percent


def remark(tree: dict, label: str, twin: bool = True) -> str:
    (row,) = [r for r in compare([tree], twin) if r.label == label]
    return row.remark


@pytest.mark.parametrize(
    ("rmse", "verdict"),
    [(9.0, "larger than under either"), (3.0, "between the two"), (1.0, "smaller than under")],
)
def test_the_ambiguous_error_is_compared_both_ways(rmse: float, verdict: str) -> None:
    tree = {"objects": {"svm": {"rmse": rmse, "mae": rmse, "mse": rmse**2}}}
    assert verdict in remark(tree, "Unseen objects, SVM: RMSE")
    assert "2.04" in remark(tree, "Unseen objects, SVM: RMSE")


@pytest.mark.parametrize(
    ("ends", "verdict"),
    [([0.96, 0.98], "inside"), ([0.98, 1.0], "below"), ([0.5, 0.9], "above")],
)
def test_the_published_accuracy_is_placed_against_the_interval(
    ends: list[float], verdict: str
) -> None:
    scores = {"accuracy": 0.97, "n": 250, "intervals": {"accuracy": ends}}
    tree = {"blocks": {"svm": {"random_90_10": scores}}}
    assert f"lies {verdict}" in remark(tree, "Blocks, SVM: accuracy, random 90/10")


def test_a_missed_target_is_said() -> None:
    label = "Contact, SVM: pinches right"
    met = {"contact": {"svm": {"window_accuracy": 0.9995, "pinch_success": 0.998}}}
    missed = {"contact": {"svm": {"window_accuracy": 0.9995, "pinch_success": 0.99}}}
    assert "is reached" in remark(met, label)
    assert "is not reached." in remark(missed, label)
    rows = compare([met, missed], True)
    assert "not reached in every" in next(r.remark for r in rows if r.label == label)


def test_agreement_of_an_input_is_not_called_a_result() -> None:
    tree = {"offset_ms": {"mean": 16.6, "sd": 10.3, "share_below_15": 0.5}}
    assert "input of the twin" in remark(tree, "First to second contact, mean")
    assert "input" not in remark(tree, "First to second contact, mean", twin=False)


def test_what_is_not_there_has_no_row() -> None:
    assert compare([{"data": {}}], True) == []


def test_percentages_are_not_rounded_up_to_all() -> None:
    assert percent(1.0) == "100.0 %"
    assert percent(0.99996) == "99.996 %"
    assert percent(0.972) == "97.2 %"
