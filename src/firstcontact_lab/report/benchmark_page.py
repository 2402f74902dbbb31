"""The page of a benchmark: one file that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import counted, percent
from firstcontact.models import AnytimeScores, Ends
from firstcontact_lab.report._anytime_tables import (
    objects_off_blocks,
    others_off_blocks,
    shown_ends,
    title_of,
)
from firstcontact_lab.report._tables import Cell, Row, Table, shown_number
from firstcontact_lab.report.figures.generalise import generalise_figure
from firstcontact_lab.report.figures.scores_by_time import scores_by_time_figure
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.page import duration
from firstcontact_lab.report.results.benchmark import (
    Benchmarked,
    BenchmarkResults,
    RecordedData,
    RecordedScores,
)
from firstcontact_lab.report.results.study import SubjectResults
from firstcontact_lab.report.template import filled


def tables(found: Benchmarked) -> list[Table]:
    """Off the blocks as studies have it, then unseen objects by the time after the contact."""
    off = SubjectResults(generalise=found.generalise)
    made = (
        objects_off_blocks(off),
        others_off_blocks(off),
        by_time(found.anytime, _TWIN_OBJECTS),
    )
    return [table for table in made if table is not None]


def recorded_parts(found: RecordedData) -> list[tuple[str, Table, Figure]]:
    """Return heading, table and figure of each group of recorded pinches."""
    its = found.held_out
    caption = (
        f'Pinches of role "train". Each of {its.folds} folds holds out whole {its.cluster}s and '
        f"learns from the others, {its.learned:,.0f} pinches on average."
    )
    if its.cluster == "session":
        caption += " The same specimens may be in other sessions."
    groups = [(f"Held-out {its.cluster}s", its, caption)]
    if found.objects is not None:
        caption = 'Pinches of role "test". Models learn from all pinches of role "train", '
        caption += f"{found.objects.learned:,.0f} in number."
        groups.append(("Unseen objects", found.objects, caption))
    return [
        (
            title,
            by_time(scored.scores, f"{caption} {_intervals(scored)}"),
            scores_by_time_figure(scored.scores, f"{title} by the time after the contact"),
        )
        for title, scored, caption in groups
    ]


def _intervals(scored: RecordedScores) -> str:
    """Say what intervals resample."""
    if scored.clusters < 2:
        return f"There is no bootstrap interval: all pinches are of one {scored.cluster}."
    return f"In brackets: 95 % bootstrap interval over {scored.clusters} {scored.cluster}s."


#: Opening words by the source of recordings.
_SOURCES = {
    "twin": "Twin results, on recordings of simulated pinches",
    "real": "Results on real recordings",
    "synthetic": "Results on synthetic recordings",
}
#: Caption of the table by time for rigs of the twin.
_TWIN_OBJECTS = (
    "Unseen objects by the time after the contact. In brackets: 95 % bootstrap interval over "
    "specimens."
)


def about(results: BenchmarkResults) -> list[str]:
    """Say which data were used."""
    found = results.recordings
    if found is None:
        return ["Twin results: contacts of simulated rigs, with hands and specimens of their own "
                "seeds."]  # fmt: skip
    levels = ", ".join(f"{level:g}" for level in found.levels)
    said = [
        f"{_SOURCES.get(found.source, 'Recordings')}: {found.path}, "
        f"{counted(found.pinches, 'pinch')}, Shore A {levels} to learn from.",
        f"Contacts: {found.contacts}.",
        f"Not scored: {counted(found.unused, 'pinch')} without contact or Shore A, "
        f"{found.too_short:,} whose second contact came before any estimate.",
    ]
    return [*said, found.left_out] if found.left_out else said


def by_time(found: Mapping[str, AnytimeScores], caption: str) -> Table:
    """Return errors, coverage and width of all competitors at each time."""
    times = list(next(iter(found.values())).rmse)
    rows = []
    for name, scores in found.items():
        ends = scores.intervals.get("rmse", {})
        errors = [Cell(shown_number(scores.rmse[ms], 1), _brackets(ends.get(ms))) for ms in times]
        shares = [
            Cell(f"{percent(scores.coverage[ms], 0)} in ±{scores.width[ms] / 2:.1f}")
            for ms in times
        ]
        rows.append(Row([Cell(title_of(name), counted(scores.n, "pinch")), *errors]))
        rows.append(Row([Cell("90 % interval"), *shares]))
    caption += (
        " First rows: RMSE in Shore A. Second rows: share of truths in the 90 % interval, and half "
        "its mean width. Estimators of a fixed window have one model a length. Signal from the "
        "second finger's contact on is left out."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in times)], rows)


def _brackets(ends: Ends | None) -> str:
    return f"({shown_ends(ends, 1)})" if ends else ""


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
    if results.recordings is not None:
        parts += [(name, [table], [figure]) for name, table, figure in
                  recorded_parts(results.recordings)]  # fmt: skip
    return filled(
        "firstcontact_lab.report",
        "benchmark.html",
        results=results,
        about=about(results),
        parts=parts,
        elapsed=duration(results.seconds),
    )


def in_words(results: BenchmarkResults) -> list[str]:
    """The tables for a terminal."""
    lines = about(results)
    for name, found in results.conditions.items():
        lines += ["", name]
        for table in tables(found):
            lines += [*_aligned(table), ""]
    for name, table, _ in [] if results.recordings is None else recorded_parts(results.recordings):
        lines += ["", name, table.caption, *_aligned(table, with_small=True)]
    return lines


def _aligned(table: Table, with_small: bool = False) -> list[str]:
    """Return a table as lines with aligned columns."""
    head, *rows = [
        table.head,
        *(
            [f"{c.text} {c.small}".rstrip() if with_small else c.text for c in row.cells]
            for row in table.rows
        ),
    ]
    wide = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
    lines = []
    for row in (head, *rows):
        first, *others = (text.rjust(w) for text, w in zip(row, wide, strict=True))
        lines.append("  ".join([first.strip().ljust(wide[0]), *others]).rstrip())
    return lines
