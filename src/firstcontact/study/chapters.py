"""Chapters of the report: which tables and figures belong together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from firstcontact.study.comparison import get
from firstcontact.study.contact_tables import answer_table, contact_table
from firstcontact.study.figures.style import NAMES
from firstcontact.study.state import Findings
from firstcontact.study.subject import Figure
from firstcontact.study.tables import (
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

Tree = Mapping[str, Any]
Maker = Callable[[Tree], Table | None]


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


@dataclass(frozen=True, slots=True)
class _Plan:
    anchor: str
    title: str
    text: str
    tables: Sequence[Maker]
    figures: Sequence[str]


_PLANS = (
    _Plan(
        "data",
        "The data",
        "What was touched, and when each finger touched it.",
        [data_table],
        ["timing", "offsets"],
    ),
    _Plan(
        "contact",
        "Contact detection",
        "20 ms windows, 3 ms of them new. Every pinch is judged by a detector that did not learn "
        "from it, and the windows that stiffness is read from start where that detector says, "
        "unless the labels could not train one (what was left out says so). "
        "Where a contact is placed and when that is decided are two things, because a detector "
        "looks back from its trigger: both are scored.",
        [contact_table],
        ["detectors", "delays"],
    ),
    _Plan(
        "waveforms",
        "What contact looks like",
        "The first 15 ms on the piezo of the finger that touched.",
        [],
        ["responses", "peaks"],
    ),
    _Plan(
        "blocks",
        "Discrimination and regression",
        "Every number stands on its floors: the mean (or most frequent class) of what was "
        "learned, and the peak amplitude alone. Small numbers are 95 % bootstrap intervals.",
        [
            lambda tree: block_table(tree, "random_90_10"),
            lambda tree: block_table(tree, "by_session"),
            lambda tree: block_table(tree, "leave_one_shore_out"),
        ],
        ["confusion-svm", "confusion-cnn", "levels"],
    ),
    _Plan(
        "objects",
        "Unseen objects",
        "No model has seen these objects. Small numbers are 95 % bootstrap "
        "intervals over whole objects, of which there are few.",
        [object_table, per_object_table],
        ["boxes-svm", "boxes-cnn"],
    ),
    _Plan("length", "Window length", "", [length_table], ["lengths"]),
    _Plan("second", "Second contact in the window", "", [second_table], ["second"]),
    _Plan(
        "hardness",
        "Order of hardness",
        "There are no Shore values here, so no error in Shore A can be given: only whether "
        "materials come in the right order.",
        [hardness_table],
        ["hardness", "materials"],
    ),
    _Plan(
        "answer",
        "Time to an answer",
        "How long after the first contact a stiffness could be told. Where second contacts are "
        "known: in how many pinches that is before the other finger touches.",
        [answer_table],
        [],
    ),
    _Plan("time", "Time of one estimate", "", [inference_table], []),
)


def subject_title(findings: Findings) -> str:
    """Name of a subject as it is written; the twin's says so."""
    name = NAMES.get(findings.name, findings.name)
    return f"{name} (twin)" if get(findings.tree, "data.source") == "twin" else name


def chapters(shown: Sequence[Findings]) -> list[Chapter]:
    """All chapters that have something to show."""
    out = []
    for plan in _PLANS:
        columns = []
        for findings in shown:
            tables = [t for make in plan.tables if (t := make(findings.tree)) is not None]
            figures = [findings.figures[k] for k in plan.figures if k in findings.figures]
            if tables or figures:
                columns.append(Column(subject_title(findings), tables, figures))
        if columns:
            out.append(Chapter(plan.anchor, plan.title, plan.text, columns))
    return out
