"""Headlines show both models, and only what is there."""

from __future__ import annotations

import pytest

from firstcontact.contact import DETECTORS
from firstcontact_lab.report.findings import Card
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.study.page import cards
from partial import results


def only(**subjects: SubjectResults) -> Card:
    """The one card of these subjects."""
    (card,) = cards(subjects)
    return card


def test_both_models_stand_in_a_headline_whichever_is_better() -> None:
    errors = {"svm": {"rmse": 9.0}, "cnn": {"rmse": 5.0}, "train_mean": {"rmse": 12.0}}
    found = results(objects=errors)
    card = only(A=found)
    assert [(line.name, line.value) for line in card.lines] == [("SVM", "9.00"), ("CNN", "5.00")]
    assert "12.0" in card.foot
    assert [line.name for line in only(A=found, B=results()).lines] == ["SVM, A", "CNN, A"]


def test_what_was_accepted_is_said() -> None:
    placed = {"pinch_success": 1.0, "decided_within_3_ms": 0.5, "delay_ms": {"median": 2.0}}
    found = {DETECTORS.default: placed}
    headline = only(A=results(contact={**found, "early_ms": 0.0}))
    assert "placed within ±3 ms of the known contact" in headline.foot
    headline = only(A=results(contact={**found, "early_ms": 4.0}))
    assert "from 7 ms before its label" in headline.foot
    assert headline.lines[0].note.startswith("decided −4 to +3 ms from its label in 50.0 %")
    assert "median delay after its label" in headline.lines[0].note


CONFUSION = [[20, 5], [10, 65]]


def test_chance_is_that_of_the_best_constant_by_the_metric_of_the_headline() -> None:
    classes = {"accuracy": 0.85, "n": 100, "classes": [0.0, 1.0], "confusion": CONFUSION}
    order = {"leave_one_material_out": {"classification": {"svm": classes}}}
    found = results(hardness_order=order)
    headline = only(A=found)
    assert headline.lines[0].value == "85.0 %"
    assert "75.0 %" in headline.foot


def test_a_material_never_learned_has_its_balanced_accuracy() -> None:
    balanced = {"3": 0.913, "5": 0.92, "15": 0.939}
    short = {"material_held_out": balanced, "chance": 0.5}
    classes = {"accuracy": 0.85, "n": 100, "classes": [0.0, 1.0], "confusion": CONFUSION}
    order = {"leave_one_material_out": {"classification": {"svm": classes}}}
    headline = only(A=results(hardness_order=order, real={"pads": short}))
    assert headline.lines[0].value == "91.3 % / 93.9 %"
    assert "50.0 %" in headline.foot


def test_preempted_calls_and_the_load_are_said() -> None:
    timed = {
        "p99": 90.0, "speedup": 4.0, "reference": "PyTorch", "preempted": 7, "calls": 1000,
        "load": 2.2, "cores": 2,
    }  # fmt: skip
    headline = only(A=results(inference_us={"svm": timed}))
    assert headline.lines[0].value == "90 µs"
    assert "(load 2.2 on 2 cores); 7 of 1,000 calls were preempted and are apart" in headline.foot


@pytest.mark.parametrize(
    ("busy", "why"),
    [
        ({"preempted": 5181, "calls": 100_000}, "5,181 of 100,000 calls were preempted: 5.2 %"),
        ({"load": 8.2}, "load 8.2 on 2 cores; at most 4 may be"),
    ],
)
def test_a_busy_machine_has_no_headline_of_its_time(busy: dict[str, float], why: str) -> None:
    timed = {"p99": 90.0, "preempted": 0, "calls": 1000, "load": 1.0, "cores": 2} | busy
    headline = only(A=results(inference_us={"svm": timed}))
    (line,) = headline.lines
    assert line.value == "–"
    assert why in line.note
    assert "90" not in line.note + headline.foot
    assert "--out" in headline.foot


def test_the_answer_names_the_twin() -> None:
    found = results(data={"source": "twin"}, answer_ms={"median": 16.0, "before_second": 0.4})
    headline = only(A=found)
    assert headline.lines[0].value == "40.0 %"
    assert "twin" in headline.foot
    assert cards({"A": results(answer_ms={"n": 0, "of": 3})}) == []


def test_estimates_at_any_time_have_a_card_of_their_own() -> None:
    late = {"before_second": 0.4, "median": 15.6}
    found = results(answer_ms=late, anytime={"before_second": 0.9, "rmse": {"5": 6.0}})
    assert [card.lines[0].value for card in cards({"A": found})] == ["40.0 %", "90.0 %"]
