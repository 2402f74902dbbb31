"""The report agrees with the results and needs no other file."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest
from toys import household as toy_household
from toys import state as toy_state

from firstcontact_lab.grasping.page import fronts_figure, fronts_picture, household_tables
from firstcontact_lab.grasping.results import Between, Household
from firstcontact_lab.grasping.sentences import headline, sentences, shortly
from firstcontact_lab.report.page import render


@pytest.fixture
def household() -> Household:
    return toy_household()


def test_the_page_holds_the_numbers_and_nothing_from_elsewhere(household: Household) -> None:
    state = toy_state()
    page = render(state)
    for text in ("Quick study", "seed 3", "18 judged pinches", "grasp-study &lt;b&gt;", "1100"):
        assert text in page
    for sentence in sentences(household):
        assert sentence in page
    for table in household_tables(state.findings[0].results):
        assert table.lines
        assert all(len(line.cells) == len(table.head) for line in table.lines), table.caption
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


def test_the_target_is_met_where_the_gain_is_large_and_no_chance(household: Household) -> None:
    def with_gain(value: float, low: float) -> str:
        gain = Between(value=value, low=low, high=0.9)
        return headline(msgspec.structs.replace(household, fewer_drops_than_blind=gain))

    assert "is met." in with_gain(0.5, 0.1)
    assert "is not met: the interval includes zero." in with_gain(0.5, -0.1)
    assert "is not met." in with_gain(0.3, 0.1)
    assert "50 % (−90 to 70) more drops: not significant." in with_gain(-0.5, -0.7)


def test_the_short_sentences_say_what_is_sure_and_what_a_reflex_leaves(
    household: Household,
) -> None:
    text = shortly(household)
    assert "drops 50 % (10 to 90) fewer of 9" in text
    assert "With a slip reflex, stiffness saves 50 to 50 % of its drops." in text
    reflexes = dict(household.slip_reflex)
    name = next(iter(reflexes))
    zero = Between(value=0.0, low=0.0, high=0.0)
    reflexes[name] = msgspec.structs.replace(reflexes[name], fewer=zero)
    gain = Between(value=0.4, low=-0.1, high=0.9)
    text = shortly(
        msgspec.structs.replace(household, slip_reflex=reflexes, fewer_drops_than_blind=gain)
    )
    assert "40 % (−10 to 90)" in text
    assert "an interval that includes zero" in text
    assert f"({name}) no gain is left" in text


def test_figures_are_drawn_from_the_results(household: Household, tmp_path: Path) -> None:
    path = tmp_path / "grasp.png"
    fronts_picture(household, path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert fronts_figure(household).image.startswith("data:image/svg")
