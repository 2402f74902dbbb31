"""Chapters of the report: which tables and figures belong together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from firstcontact_lab.report import _texts as texts
from firstcontact_lab.report._anytime_tables import (
    anytime_table,
    objects_off_blocks,
    others_off_blocks,
)
from firstcontact_lab.report._board_tables import board_table
from firstcontact_lab.report._contact_tables import answer_table, contact_table
from firstcontact_lab.report._short_tables import materials_table, short_table
from firstcontact_lab.report._tables import (
    Table,
    block_table,
    data_table,
    hardness_table,
    inference_table,
    length_table,
    object_table,
    per_object_table,
    second_table,
)
from firstcontact_lab.report.findings import Figure, Findings
from firstcontact_lab.report.results.study import SubjectResults

#: Most columns of a table that stands beside another.
_HALF = 8

Maker = Callable[[SubjectResults], Table | None]


@dataclass(frozen=True, slots=True)
class Column:
    """What one subject has in a chapter."""

    title: str
    tables: Sequence[Table]
    figures: Sequence[Figure]


@dataclass(frozen=True, slots=True)
class Chapter:
    """A chapter with a column for each subject that has something in it."""

    anchor: str
    title: str
    text: str
    columns: Sequence[Column]

    @property
    def wide(self) -> bool:
        """Whether a table has more columns than half a page has room for."""
        tables = (table for column in self.columns for table in column.tables)
        return any(len(table.head) > _HALF for table in tables)


@dataclass(frozen=True, slots=True)
class _Plan:
    anchor: str
    title: str
    text: Callable[[Sequence[SubjectResults]], str]
    tables: Sequence[Maker]
    figures: Sequence[str]


_PLANS = (
    _Plan("data", "The data", texts.data, [data_table], ["timing", "offsets"]),
    _Plan("contact", "Contact detection", texts.contact, [contact_table], ["detectors", "delays"]),
    _Plan("waveforms", "What contact looks like", texts.waveforms, [], ["responses", "peaks"]),
    _Plan(
        "blocks",
        "Discrimination and regression",
        texts.blocks,
        [
            lambda results: block_table(results, "random_90_10"),
            lambda results: block_table(results, "by_session"),
            lambda results: block_table(results, "leave_one_shore_out"),
        ],
        ["confusion-*", "levels"],
    ),
    _Plan(
        "objects",
        "Unseen objects",
        texts.objects,
        [object_table, per_object_table],
        ["boxes-*"],
    ),
    _Plan("length", "Window length", texts.nothing, [length_table], ["lengths-*"]),
    _Plan("second", "Second contact in the window", texts.nothing, [second_table], ["second"]),
    _Plan(
        "hardness",
        "Order of hardness",
        texts.hardness,
        [hardness_table],
        ["hardness", "materials"],
    ),
    _Plan(
        "short",
        "Short windows of materials left out",
        texts.short,
        [short_table, materials_table],
        ["short", "short-materials", "short-order"],
    ),
    _Plan("answer", "Time to an answer", texts.answer, [answer_table], []),
    _Plan("anytime", "Answers at any time", texts.anytime, [anytime_table], ["anytime"]),
    _Plan(
        "generalise",
        "Off the blocks",
        texts.generalise,
        [objects_off_blocks, others_off_blocks],
        ["generalise"],
    ),
    _Plan("time", "Time of one estimate", texts.nothing, [inference_table, board_table], []),
)


def subject_title(findings: Findings) -> str:
    """Name of a subject as it is written; the twin's says so."""
    return f"{findings.title} (twin)" if findings.results.twin else findings.title


def chapters(shown: Sequence[Findings]) -> list[Chapter]:
    """All chapters that have something to show."""
    out = []
    for plan in _PLANS:
        columns = []
        for findings in shown:
            its = findings.figures.items()
            tables = [t for make in plan.tables if (t := make(findings.results)) is not None]
            figures = [f for key in plan.figures for k, f in its if fnmatchcase(k, key)]
            if tables or figures:
                columns.append(Column(subject_title(findings), tables, figures))
        if columns:
            text = plan.text([findings.results for findings in shown])
            out.append(Chapter(plan.anchor, plan.title, text, columns))
    return out
