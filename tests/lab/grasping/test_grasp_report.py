"""The report agrees with the results and needs no other file."""

import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from firstcontact_lab.grasping.page import (
    GRASP_PARTS,
    HOUSEHOLD,
    fronts_figure,
    fronts_picture,
    grasp_page,
    household_tables,
)
from firstcontact_lab.grasping.results import Between, Household
from firstcontact_lab.grasping.sentences import readme_sentences, sentences
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.page import State, render
from firstcontact_lab.study.page import read_study

RESULTS = read_study(Path(__file__).parents[3] / "docs/results/grasp.json").about


@pytest.fixture
def household() -> Household:
    computed = RESULTS[HOUSEHOLD]
    assert computed is not None
    return computed


def test_the_page_holds_the_numbers_and_nothing_from_elsewhere(household: Household) -> None:
    state = State(
        command="firstcontact grasp-study <b>",
        settings={"seed": 3, "workers": 2},
        options={},
        parts=GRASP_PARTS,
        page=grasp_page,
        quick=True,
        findings=[Findings("twin", RESULTS)],
    )
    page = render(state)
    for text in ("Quick study", "seed 3", f"{household.picks} judged", "grasp-study &lt;b&gt;"):
        assert text in page
    for sentence in sentences(household):
        assert sentence in page
    for table in household_tables(RESULTS):
        assert table.lines
        assert all(len(line.cells) == len(table.head) for line in table.lines), table.caption
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


@pytest.mark.parametrize(
    ("value", "low", "met"), [(0.5, 0.1, True), (0.5, -0.1, False), (0.3, 0.1, False)]
)
def test_the_target_is_met_where_the_gain_is_large_and_no_chance(
    household: Household, value: float, low: float, met: bool
) -> None:
    gain = Between(value=value, low=low, high=0.9)
    changed = replace(household, fewer_drops_than_blind=gain)
    assert changed.met == met
    assert ("interval" in readme_sentences(changed).split(".")[0]) == (low < 0)


def test_figures_are_drawn_from_the_results(household: Household, tmp_path: Path) -> None:
    path = tmp_path / "grasp.png"
    fronts_picture(household, path)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert fronts_figure(household).image.startswith("data:image/svg")
