"""The report: tables side by side, and text that cannot be shown as it is."""

from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.page import Column, Section, render
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.report.tables import Cell, Line, Table, beside
from firstcontact_lab.study.sets import SET, SetResults, sets_page
from partial import study_state


def test_a_command_that_is_not_utf8_is_shown_all_the_same() -> None:
    state = study_state(command="firstcontact study --out \udcff", findings=[Findings("a")])
    assert r"study --out \udcff" in render(state)


def test_a_table_of_many_columns_does_not_stand_beside_another() -> None:
    narrow, broad = (Table("", ["x"] * columns, []) for columns in (5, 12))
    assert not Section("a", "A", "", details=[Column("one", [narrow], [])]).wide
    assert Section("a", "A", "", details=[Column("one", [narrow, broad], [])]).wide


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


def test_no_page_holds_a_control_character() -> None:
    hostile = "\x1b[31m\x1b]0;owned\x07\x9b2J\u202ec\x7f"
    entry = SetResults(
        n=1, sensor=hostile, rate_hz=5000.0, front_end=hostile, pinches=1, materials=1
    )
    findings = [Findings(f"set {hostile}", NOTHING.replace([SET(entry)]))]
    displayed = render(study_state(command=hostile, parts={}, page=sets_page, findings=findings))
    assert all(c in "\n\t" or c.isprintable() for c in displayed)
    assert displayed.count(r"\u001b[31m") == 4
