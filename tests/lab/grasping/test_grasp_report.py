"""The report agrees with the results and needs no other file."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest
from toy_results import results as toy_results

from firstcontact_lab.grasping.chapters import render, tables
from firstcontact_lab.grasping.figures import fronts_figure, fronts_picture
from firstcontact_lab.grasping.results import Between, GraspResults
from firstcontact_lab.grasping.sentences import headline, reflex_sentence, sentences, shortly


@pytest.fixture
def results() -> GraspResults:
    return toy_results()


def test_the_page_holds_the_numbers_and_nothing_from_elsewhere(
    results: GraspResults, tmp_path: Path
) -> None:
    (tmp_path / "film.gif").write_bytes(b"GIF89a")
    page = render(results, tmp_path / "film.gif")
    for text in ("Quick study", "seed 3", "18 judged pinches", "grasp-study &lt;b&gt;", "1100"):
        assert text in page
    for sentence in sentences(results):
        assert sentence in page
    for table in tables(results):
        assert table.lines
        assert all(len(line.cells) == len(table.head) for line in table.lines), table.caption
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


def test_the_target_is_met_where_the_gain_is_large_and_no_chance(results: GraspResults) -> None:
    def with_gain(value: float, low: float) -> str:
        gain = Between(value=value, low=low, high=0.9)
        computed = msgspec.structs.replace(results.household, fewer_drops_than_blind=gain)
        return headline(computed)

    assert "is met." in with_gain(0.5, 0.1)
    assert "is not met: the interval includes zero." in with_gain(0.5, -0.1)
    assert "is not met." in with_gain(0.3, 0.1)
    assert "50 % (10 to 90) fewer drops. A hand" in with_gain(0.5, 0.1)
    assert "50 % (−90 to 70) more drops: not significant." in with_gain(-0.5, -0.7)


def test_the_short_word_says_what_is_sure_and_what_a_reflex_leaves(results: GraspResults) -> None:
    text = shortly(results.household)
    assert "drops 50 % (10 to 90) fewer of 9" in text
    assert "With a slip reflex, stiffness saves 50 to 50 % of its drops." in text
    entry = dict(results.household.slip_reflex)
    name = next(iter(entry))
    zero = Between(value=0.0, low=0.0, high=0.0)
    entry[name] = msgspec.structs.replace(entry[name], fewer=zero)
    gain = Between(value=0.4, low=-0.1, high=0.9)
    text = shortly(
        msgspec.structs.replace(results.household, slip_reflex=entry, fewer_drops_than_blind=gain)
    )
    assert "40 % (−10 to 90)" in text
    assert "an interval that includes zero" in text
    assert f"({name}) no gain is left" in text


def test_every_reflex_is_in_the_sentence(results: GraspResults) -> None:
    text = reflex_sentence(results.household)
    for name in results.household.slip_reflex:
        assert f"20 % to 10 % ({name})" in text


def test_figures_are_drawn_from_the_results(results: GraspResults, tmp_path: Path) -> None:
    path = tmp_path / "grasp.png"
    fronts_picture(results.household, path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert fronts_figure(results.household).startswith("data:image/svg")
