"""Report of a benchmark: one HTML file that needs no other file."""

from __future__ import annotations

from collections.abc import Mapping

from firstcontact.core import BLUE, GREEN, ORANGE, PURPLE, RED, SKY, Record, counted, percent
from firstcontact.models import CLUSTERS, Bounded
from firstcontact_lab.report.findings import Figure
from firstcontact_lab.report.names import competitor_title
from firstcontact_lab.report.page import Column, Page, Section
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.report.state import duration
from firstcontact_lab.report.style import canvas, uri
from firstcontact_lab.report.tables import Cell, Line, Table, format_cell, plain_lines
from firstcontact_lab.study.benchmark import Benchmarked
from firstcontact_lab.study.parts.generalise import (
    GENERALISE,
    generalise_figure,
    objects_off_blocks,
    others_off_blocks,
)
from firstcontact_lab.study.recorded_benchmark import RecordedData, RecordedScores
from firstcontact_lab.study.scores import AnytimeScores


class BenchmarkResults(Record, frozen=True, kw_only=True):
    """``results.json`` of a benchmark: estimator, settings and scores."""

    contender: str
    command: str
    quick: bool
    seed: int
    seconds: float
    versions: dict[str, str]
    conditions: dict[str, Benchmarked]
    recordings: RecordedData | None = None


_COLOURS = (RED, BLUE, GREEN, ORANGE, PURPLE, SKY)
_PANELS = {
    "rmse": "RMSE (Shore A)",
    "coverage": "Truth in the interval",
    "width": "Mean width of the interval (Shore A)",
}


def scores_by_time_figure(
    results: Mapping[str, AnytimeScores],
    title: str = "Unseen objects by the time after the contact",
) -> Figure:
    """Plot error, and coverage and width of intervals, against the time after the contact."""
    with canvas(1, len(_PANELS), (9.0, 3.4)) as (figure, axes):
        for ax, (key, label) in zip(axes[0], _PANELS.items(), strict=True):
            for number, (name, scores) in enumerate(results.items()):
                values: dict[str, float] = getattr(scores, key)
                colour = _COLOURS[number % len(_COLOURS)]
                times = [float(ms) for ms in values]
                ax.plot(times, list(values.values()), "o-", ms=4, color=colour,
                        label=competitor_title(name))  # fmt: skip
            ax.set(xlabel="After contact (ms)", ylabel=label, xlim=(0, None), ylim=(0, None))
        axes[0, 0].legend(loc="best")
        image = uri(figure)
    return Figure(
        "scores-by-time",
        title,
        "Signal after that time, or after the second contact, is left out.",
        image,
    )


def tables(results: Benchmarked) -> list[Table]:
    """Return the tables of scores beyond the blocks, and on unseen objects by time."""
    off = NOTHING.replace([GENERALISE(results.generalise)])
    made = (
        objects_off_blocks(off),
        others_off_blocks(off),
        by_time(results.anytime, _TWIN_OBJECTS),
    )
    return [table for table in made if table is not None]


def recorded_parts(results: RecordedData) -> list[tuple[str, Table, Figure]]:
    """Return heading, table and figure of held-out sessions, and of unseen objects if any."""
    group_scores = results.held_out
    caption = (
        f'Pinches of role "train". Each of {group_scores.folds} folds holds out whole '
        f"{group_scores.cluster}s and "
        f"trains on the others, {group_scores.learned:,.0f} pinches on average."
    )
    if group_scores.cluster == "session":
        caption += " The same specimens may be in other sessions."
    groups = [(f"Held-out {group_scores.cluster}s", group_scores, caption)]
    if results.objects is not None:
        caption = 'Pinches of role "test". Models learn from all pinches of role "train", '
        caption += f"{results.objects.learned:,.0f} in number."
        groups.append(("Unseen objects", results.objects, caption))
    return [
        (
            title,
            by_time(scored.scores, f"{caption} {_intervals(scored)}"),
            scores_by_time_figure(scored.scores, f"{title} by the time after the contact"),
        )
        for title, scored, caption in groups
    ]


def _intervals(scored: RecordedScores) -> str:
    """Return a sentence on the intervals: they resample sessions or specimens."""
    if scored.clusters < CLUSTERS:
        few = counted(scored.clusters, scored.cluster)
        return f"There is no bootstrap interval: {few} are too few, at least {CLUSTERS} are needed."
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
    "objects; a specimen of each on every rig."
)


def about(results: BenchmarkResults) -> list[str]:
    """Return sentences about the data."""
    outcome = results.recordings
    if outcome is None:
        return ["Twin results: contacts of simulated rigs. Hands and specimens have other seeds "
                "than in any training."]  # fmt: skip
    levels = ", ".join(f"{level:g}" for level in outcome.levels)
    lines = [
        f"{_SOURCES.get(outcome.source, 'Recordings')}: {outcome.path}, "
        f"{counted(outcome.pinches, 'pinch')}, Shore A {levels} to learn from.",
        f"Contacts: {outcome.contacts}.",
        *([f"{outcome.detector[0].upper()}{outcome.detector[1:]}."] if outcome.detector else []),
        f"Not scored: {counted(outcome.unused, 'pinch')} without contact or Shore A, "
        f"{outcome.too_short:,} whose second contact came before any estimate.",
    ]
    return [*lines, outcome.left_out] if outcome.left_out else lines


def by_time(results: Mapping[str, AnytimeScores], caption: str) -> Table:
    """Return a table of all competitors: errors, and coverage and width of intervals by time."""
    times = list(next(iter(results.values())).rmse)
    lines = []
    for name, scores in results.items():
        ends = scores.intervals.get("rmse", {})
        errors = [format_cell(Bounded(scores.rmse[ms], ends.get(ms)), "shore") for ms in times]
        shares = [
            Cell(f"{percent(scores.coverage[ms], 0)} in ±{scores.width[ms] / 2:.1f}")
            for ms in times
        ]
        lines.append(Line([Cell(competitor_title(name), counted(scores.n, "pinch")), *errors]))
        lines.append(Line([Cell("90 % interval"), *shares]))
    caption += (
        " First rows: RMSE in Shore A. Second rows: share of truths in the 90 % interval, and half "
        "its mean width. Estimators with a fixed window have one model for each length. Signal "
        "from the second finger's contact on is left out."
    )
    return Table(caption, ["", *(f"{ms} ms" for ms in times)], lines)


def render(results: BenchmarkResults) -> str:
    """Return the report, HTML."""
    parts = [
        (
            name,
            tables(outcome),
            [generalise_figure(outcome.generalise), scores_by_time_figure(outcome.anytime)],
        )
        for name, outcome in results.conditions.items()
    ]
    if results.recordings is not None:
        parts += [(name, [table], [figure]) for name, table, figure in
                  recorded_parts(results.recordings)]  # fmt: skip
    return Page(
        title=f"Benchmark of {results.contender}",
        heading=f"Benchmark of {results.contender}",
        intro=" ".join(about(results)),
        badges=["Benchmark", f"seed {results.seed}", duration(results.seconds)],
        warning="Quick benchmark: do not quote its numbers" if results.quick else "",
        sections=[
            Section(f"part-{place}", name, "", [Column(name, tables, figures)])
            for place, (name, tables, figures) in enumerate(parts)
        ],
        command=results.command,
        how=[("Seed", [str(results.seed)]), ("Time", [duration(results.seconds)])],
        versions=results.versions,
    ).html()


def in_words(results: BenchmarkResults) -> list[str]:
    """Return the tables of a benchmark as lines for a terminal."""
    lines = about(results)
    for name, outcome in results.conditions.items():
        lines += ["", name]
        for table in tables(outcome):
            lines += [*plain_lines(table), ""]
    for name, table, _ in [] if results.recordings is None else recorded_parts(results.recordings):
        lines += ["", name, table.caption, *plain_lines(table, small=True)]
    return lines
