"""Numbers in tables of the site stay on the line of their units."""

from __future__ import annotations

import pytest
from join_units import join_units

NO_BREAK = "\u00a0"


@pytest.mark.parametrize(
    "cell",
    ["16.65_ms", "95.3_% of 7 pinches", "4 to 15_ms", "5_MB", "2_m/s", "6.37_Shore A", "12.5_×"],
)
@pytest.mark.parametrize("tag", ["td", "th"])
def test_units_in_cells_follow_a_no_break_space(tag: str, cell: str) -> None:
    html = f"<tr><{tag} style='x'>{cell}</{tag}></tr>"
    assert join_units(html.replace("_", " ")) == html.replace("_", NO_BREAK)


@pytest.mark.parametrize(
    "html",
    [
        "<p>16.65 ms</p>",
        "<td>6 numbers, 3 mice, 2 s3</td>",
        "<td>run <code>sleep 5 s</code></td>",
        "<thead><tr></tr></thead><p>5 ms</p>",
    ],
)
def test_other_spaces_stay(html: str) -> None:
    assert join_units(html) == html
