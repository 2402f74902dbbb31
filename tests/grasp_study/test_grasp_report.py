"""The report says what the results hold, and needs nothing but itself."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest
from toy_rows import rows

from firstcontact.core.by_name import divided, to_tree
from firstcontact.grasp_study._chapters import sentences, tables
from firstcontact.grasp_study._numbers import by_object, by_policy, headline
from firstcontact.grasp_study._report import render
from firstcontact.grasp_study.figures.headline import headline_figure, headline_picture
from firstcontact.grasp_study.results import GraspResults
from firstcontact.grasp_study.variants import variants


@pytest.fixture
def results() -> GraspResults:
    feedback = {
        "settings": {"threshold": 0.05, "approach": 1.5, "speed": 0.02, "force": 2.6},
        "tried": 7, "peak": 3.0, "time": 0.14, "unsteady": 0.0,
    }  # fmt: skip
    tree = {
        "study": {
            "command": "firstcontact grasp-study <b>", "started": "now", "seconds": 12.0,
            "quick": True, "seed": 3, "workers": 2, "versions": {"python": "3"},
        },
        "data": {
            "source": "twin", "objects": ["block 5"], "sessions": 4, "pinches": 16,
            "closings": 224, "training": 100, "latencies_ms": [20.0, 60.0],
        },
        "models": {"rmse": {"3": 3.21}, "interval_width": {"3": 8.0}},
        "grip": {"speed": 0.13},
        "feedback": {"feedback": feedback, "feedback_fast": feedback},
        "policies": by_policy(rows(), 0),
        "objects": by_object(rows(), 0),
        "headline": headline(rows(), 0),
        "film": {"object": "block 10", "session": 2},
    }  # fmt: skip
    return msgspec.convert(to_tree(tree), GraspResults, dec_hook=divided)


def test_the_page_holds_the_numbers_and_nothing_from_elsewhere(
    results: GraspResults, tmp_path: Path
) -> None:
    (tmp_path / "film.gif").write_bytes(b"GIF89a")
    page = render(results, tmp_path / "film.gif")
    for said in ("Quick study", "seed 3", "224 closings", "3.2 Shore", "grasp-study &lt;b&gt;"):
        assert said in page
    for variant in variants().values():
        peak = results.policies[variant.key]["20"]["soft"].peak_n
        assert f"{peak:.2f} (" in page
        assert variant.title in page
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)


def test_the_target_is_judged_once_for_each_of_ours(results: GraspResults) -> None:
    said = sentences(results)
    assert sum("Target met." in s for s in said) == 2
    assert "Shore A -35 (-35 to -35) %" in " ".join(said)
    tree = to_tree(results)
    tree["headline"]["early_exit"]["feedback_fast"]["met"]["longer"] = False
    missed = msgspec.convert(tree, GraspResults, dec_hook=divided)
    assert sum("Target not met." in s for s in sentences(missed)) == 1


def test_every_variant_has_a_row_a_name_and_a_colour_of_its_own(results: GraspResults) -> None:
    compared = variants().values()
    assert [row[0] for row in tables(results)[0].rows] == [v.title for v in compared]
    for told in ({v.title for v in compared}, {v.colour for v in compared}):
        assert len(told) == len(compared)


def test_the_headline_is_written_as_a_picture(results: GraspResults, tmp_path: Path) -> None:
    path = tmp_path / "grasp.png"
    headline_picture(results.policies, "20", path)
    assert headline_figure(results.policies, "20").startswith("data:image/svg")
    assert path.read_bytes().startswith(b"\x89PNG")
