"""Headlines show both models, and only what is there."""

from __future__ import annotations

import pytest

from firstcontact.contact import DETECTORS
from firstcontact_lab.report._headlines import headlines
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.results.sets import SetResults, SetsResults
from firstcontact_lab.report.sets_page import overview
from partial import results


def test_both_models_stand_in_a_headline_whichever_is_better() -> None:
    errors = {"svm": {"rmse": 9.0}, "cnn": {"rmse": 5.0}, "train_mean": {"rmse": 12.0}}
    found = results(objects=errors)
    (headline,) = headlines([Findings("paper-rig", found)])
    assert [(line.name, line.value) for line in headline.lines] == [
        ("SVM", "9.0 Shore A"),
        ("CNN", "5.0 Shore A"),
    ]
    assert "12.0" in headline.foot
    (headline,) = headlines([Findings("paper-rig", found), Findings("everyday")])
    assert [line.name for line in headline.lines] == ["SVM, Paper rig", "CNN, Paper rig"]


def test_what_was_accepted_is_said() -> None:
    placed = {"pinch_success": 1.0, "decided_within_3_ms": 0.5, "delay_ms": {"median": 2.0}}
    found = {DETECTORS.default: placed}
    (headline,) = headlines([Findings("a", results(contact={**found, "early_ms": 0.0}))])
    assert "placed within ±3 ms of the known contact" in headline.foot
    (headline,) = headlines([Findings("a", results(contact={**found, "early_ms": 4.0}))])
    assert "from 7 ms before its label" in headline.foot
    assert headline.lines[0].note.startswith("decided −4 to +3 ms from its label in 50.0 %")
    assert "median delay after its label" in headline.lines[0].note


CONFUSION = [[20, 5], [10, 65]]


def test_chance_is_that_of_the_best_constant_by_the_metric_of_the_headline() -> None:
    classes = {"accuracy": 0.85, "n": 100, "classes": [0.0, 1.0], "confusion": CONFUSION}
    order = {"leave_one_material_out": {"classification": {"svm": classes}}}
    found = results(hardness_order=order)
    *_, headline = headlines([Findings("a", found)])
    assert headline.lines[0].value == "85.0 %"
    assert headline.foot == "accuracy; the best constant prediction has 75.0 %"


def test_a_material_never_learned_has_the_number_of_the_overview_of_sets() -> None:
    balanced = {"3": 0.913, "5": 0.92, "15": 0.939}
    short = {"material_held_out": balanced, "chance": 0.5}
    classes = {"accuracy": 0.85, "n": 100, "classes": [0.0, 1.0], "confusion": CONFUSION}
    order = {"leave_one_material_out": {"classification": {"svm": classes}}}
    found = results(hardness_order=order, real={"pads": short})
    *_, headline = headlines([Findings("a", found)])
    one = SetResults(
        n=5, sensor="", rate_hz=1.0, front_end="", pinches=5, materials=4,
        class_held_out=balanced, chance=0.5,
    )  # fmt: skip
    sets = SetsResults(command="", seconds=0.0, versions={}, sets={"pads": one})
    cell = overview(sets).rows[0].cells[-1]
    assert headline.lines[0].value == cell.text == "91.3 % / 93.9 %"
    assert headline.foot == "balanced accuracy; a constant prediction has 50.0 %"
    assert "50.0 %" in cell.small


def test_preempted_calls_and_the_load_are_said() -> None:
    timed = {
        "p99": 90.0, "speedup": 4.0, "reference": "PyTorch", "preempted": 7, "calls": 1000,
        "load": 2.2, "cores": 2,
    }  # fmt: skip
    (headline,) = headlines([Findings("a", results(inference_us={"svm": timed}))])
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
    (headline,) = headlines([Findings("a", results(inference_us={"svm": timed}))])
    (line,) = headline.lines
    assert line.value == "–"
    assert why in line.note
    assert "90" not in line.note + headline.foot
    assert "--out" in headline.foot


def test_the_answer_is_said_to_be_the_twins() -> None:
    found = results(data={"source": "twin"}, answer_ms={"median": 16.0, "before_second": 0.4})
    (headline,) = headlines([Findings("paper-rig", found)])
    assert headline.lines[0].value == "40.0 %"
    assert "twin" in headline.foot
    assert "samples" in headline.title.lower()
    assert "computing and transport left out" in headline.foot
    assert headlines([Findings("recordings", results(answer_ms={"n": 0, "of": 3}))]) == []


def test_answers_at_any_time_stand_above_those_of_the_window() -> None:
    late = {"before_second": 0.4, "median": 15.6}
    found = results(answer_ms=late, anytime={"before_second": 0.9, "rmse": {"5": 6.0}})
    (headline,) = headlines([Findings("a", found)])
    assert [(line.name, line.value) for line in headline.lines] == [
        ("A, at any time", "90.0 %"),
        ("A, 15 ms", "40.0 %"),
    ]
    (headline,) = headlines([Findings("a", results(answer_ms=late))])
    assert [line.name for line in headline.lines] == ["A"]
