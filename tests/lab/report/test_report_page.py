"""The report in a browser: equal text sizes in figures. Text that cannot be drawn is replaced."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest

from firstcontact.models import RegressionScores
from firstcontact_lab.report.findings import Findings, PartResult
from firstcontact_lab.report.page import Column, Section
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.report.state import State
from firstcontact_lab.report.tables import Cell, Line, Table, beside
from firstcontact_lab.study.page import render
from firstcontact_lab.study.parts.data import offset_figure
from firstcontact_lab.study.parts.window_length import WindowErrors, lengths_figure
from firstcontact_lab.study.set_scores import SetResults
from firstcontact_lab.study.sets import SET, sets_page
from firstcontact_lab.study.settings import StudySettings
from partial import results

CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")
#: Writes the scale at which each figure is displayed, pixels an own pixel, into the page.
MEASURE = """<script>addEventListener("load", () => {
  document.querySelectorAll("details").forEach(folded => { folded.open = true; });
  const scales = [...document.querySelectorAll(".figures img")]
    .map(image => image.getBoundingClientRect().width / image.naturalWidth);
  document.title = "scales " + scales.map(s => s.toFixed(4)).join(" ");
});</script></body>"""


def page(subjects: int) -> str:
    """Return a report of some subjects. The first one has a figure that the others lack."""
    errors = RegressionScores(rmse=1.0, mae=1.0, mse=1.0, bias=0.0, n=3, intervals={})
    scores = {"svm": WindowErrors(blocks=errors)}
    alone = lengths_figure({"3": scores, "15": scores})
    both = offset_figure(np.array([5.0, 12.0, 20.0]))
    findings = []
    for number in range(subjects):
        entry = Findings(f"subject {number}", results(data={}))
        figures = [both] if number else [both, alone]
        entry.add("window_length", PartResult((), figures))
        entry.figures["data"] = {"timing": both}
        findings.append(entry)
    state = State("firstcontact study", asdict(StudySettings()), False, findings, [])
    return render(state)


@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
@pytest.mark.parametrize(
    ("subjects", "width"),
    [
        (1, 500),
        (2, 1400),
        *(
            pytest.param(*both, marks=pytest.mark.slow)
            for both in ((1, 1400), (1, 1200), (1, 800), (2, 1200), (2, 800), (2, 500))
        ),
    ],
)
def test_text_in_figures_has_one_size(subjects: int, width: int, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(page(subjects).replace("</body>", MEASURE), encoding="utf-8")
    assert CHROMIUM is not None
    process = subprocess.run(
        [
            CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom",
            "--disable-dev-shm-usage", f"--user-data-dir={tmp_path / 'profile'}",
            f"--window-size={width},900", path.as_uri(),
        ],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    match = re.search(r"<title>scales ([\d. ]+)</title>", process.stdout)
    assert match is not None
    scales = [float(scale) for scale in match[1].split()]
    assert len(scales) == 2 * subjects + 1
    assert min(scales) > 0
    assert max(scales) <= 1.03 * min(scales)


def test_a_command_that_is_not_utf8_is_shown_all_the_same() -> None:
    state = State(
        "firstcontact study --out \udcff", asdict(StudySettings()), False, [Findings("a")], []
    )
    assert r"study --out \udcff" in render(state)


def test_a_table_of_many_columns_does_not_stand_beside_another() -> None:
    narrow, broad = (Table("", ["x"] * columns, []) for columns in (5, 12))
    assert not Section("a", "A", "", [Column("one", [narrow], [])]).wide
    assert Section("a", "A", "", [Column("one", [narrow, broad], [])]).wide


def test_subjects_stand_side_by_side_line_by_line() -> None:
    def table(*names: tuple[str, str, str]) -> Table:
        return Table(
            "", ["", "x", "y"], [Line([Cell(a, b), Cell(c), Cell("-")]) for a, b, c in names]
        )

    both = {
        "A": table(("SVM", "3 vectors", "1"), ("CNN", "with", "2"), ("CNN", "without", "3")),
        "B": table(("SVM", "4 vectors", "4"), ("CNN", "without", "5")),
    }
    merged = beside(both, ("x",))
    assert list(merged.head) == ["", "x, a", "x, b"]
    texts = [[cell.text for cell in line.cells] for line in merged.lines]
    assert texts == [["SVM", "1", "4"], ["CNN", "2", "–"], ["CNN", "3", "5"]]
    assert [list(beside({"A": both["A"]}).head), len(merged.lines)] == [["", "x", "y"], 3]


def test_what_pages_share_is_in_each_of_them() -> None:
    assert "overflow-x: auto" in page(1)
    assert "{%" not in page(1)


def test_no_page_holds_a_control_character() -> None:
    hostile = "\x1b[31m\x1b]0;owned\x07\x9b2J\u202ec\x7f"
    entry = SetResults(
        n=1, sensor=hostile, rate_hz=5000.0, front_end=hostile, pinches=1, materials=1
    )
    findings = [Findings(f"set {hostile}", NOTHING.replace([SET(entry)]))]
    displayed = sets_page(State(hostile, {"seed": 0}, False, findings, []))
    assert all(c in "\n\t" or c.isprintable() for c in displayed)
    assert displayed.count(r"\u001b[31m") == 4
