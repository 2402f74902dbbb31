"""The page of a benchmark: one file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import counted, percent
from firstcontact.models import AnytimeScores
from firstcontact_lab.report._anytime_tables import objects_off_blocks, others_off_blocks, title_of
from firstcontact_lab.report._tables import Cell, Row, Table, shown_number
from firstcontact_lab.report.figures.generalise import generalise_figure
from firstcontact_lab.report.figures.scores_by_time import scores_by_time_figure
from firstcontact_lab.report.page import duration
from firstcontact_lab.report.results.benchmark import Benchmarked, BenchmarkResults
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.report.template import filled


def tables(found: Benchmarked) -> list[Table]:
    """Off the blocks as studies have it, then unseen objects by the time after the contact."""
    off = SubjectResults(generalise=found.generalise)
    made = (objects_off_blocks(off), others_off_blocks(off), by_time(found.anytime))
    return [table for table in made if table is not None]


def by_time(found: Mapping[str, AnytimeScores]) -> Table:
    """Error, coverage and width of everybody at each time."""
    times = list(next(iter(found.values())).rmse)
    rows = []
    for name, scores in found.items():
        cells = [
            Cell(
                shown_number(scores.rmse[ms], 1),
                f"{percent(scores.coverage[ms], 0)} in ±{scores.width[ms] / 2:.1f}",
            )
            for ms in times
        ]
        rows.append(Row([Cell(title_of(name), counted(scores.n, "pinch")), *cells]))
    caption = (
        "Unseen objects by the time after the contact: RMSE in Shore A; small: share of truths in "
        "the 90 % interval, and half its mean width. Estimators of a fixed window have one model a "
        "length; what the second finger adds is shown to nobody."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in times)], rows)


def render(results: BenchmarkResults) -> str:
    """HTML."""
    parts = [
        (
            name,
            tables(found),
            [generalise_figure(found.generalise), scores_by_time_figure(found.anytime)],
        )
        for name, found in results.conditions.items()
    ]
    return filled(
        "firstcontact_lab.report",
        "benchmark.html",
        results=results,
        parts=parts,
        elapsed=duration(results.seconds),
    )


def in_words(results: BenchmarkResults) -> list[str]:
    """The tables for a terminal."""
    lines = []
    for name, found in results.conditions.items():
        lines += ["", name]
        for table in tables(found):
            head, *rows = [table.head, *([c.text for c in row.cells] for row in table.rows)]
            wide = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
            for row in (head, *rows):
                first, *others = (text.rjust(w) for text, w in zip(row, wide, strict=True))
                lines.append("  ".join([first.strip().ljust(wide[0]), *others]).rstrip())
            lines.append("")
    return lines
