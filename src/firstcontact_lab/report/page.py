"""HTML page of a report: one file, which needs no other file."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from firstcontact.core.installation import installed_versions
from firstcontact.core.records import ByName
from firstcontact.core.text import sanitize
from firstcontact_lab.report.findings import (
    PART_SECONDS,
    PENDING,
    SECONDS,
    STUDY,
    VERSIONS,
    Figure,
    Findings,
    StudyResults,
    StudyRun,
)
from firstcontact_lab.report.results import NOTHING
from firstcontact_lab.report.tables import Table, join_side_by_side

if TYPE_CHECKING:
    from jinja2 import Template

    from firstcontact_lab.study.part import Part, Subjects

#: Largest number of columns of a table that is shown next to another table.
_HALF = 8


@dataclass(slots=True, kw_only=True)
class State:
    """Progress and results of a running study, and the function that makes its report page."""

    settings: Mapping[str, Any]
    options: Mapping[str, Any]
    parts: Mapping[str, Part]
    page: Callable[[State], Page]
    quick: bool = False
    command: str = field(default_factory=lambda: shlex.join(["firstcontact", *sys.argv[1:]]))
    findings: list[Findings] = field(default_factory=list)
    steps: Sequence[str] = ()
    completed: int = 0
    interrupted: bool = False
    stopped: str = ""
    began: float = field(default_factory=time.monotonic)
    started: str = field(default_factory=lambda: time.strftime("%Y-%m-%d %H:%M %Z"))
    part_seconds: dict[str, float] = field(default_factory=dict)

    @property
    def pending(self) -> Sequence[str]:
        return self.steps[self.completed :]

    @property
    def seconds(self) -> float:
        """Time since the study began, s, by this computer's clock."""
        return time.monotonic() - self.began

    @property
    def elapsed(self) -> str:
        complete = round(self.seconds)
        minutes = f"{complete // 60} min {complete % 60:02d} s"
        text = f"{complete} s" if complete < 90 else minutes
        return text + (" so far" if self.pending else "")

    def results(self) -> StudyResults:
        first, *further = self.findings
        run = StudyRun(
            command=self.command,
            condition=first.name,
            quick=self.quick,
            started=self.started,
            complete=not self.pending,
            stopped=self.stopped or None,
            options=dict(self.options),
            settings=dict(self.settings),
            seed=self.settings["seed"],
        )
        about = first.complete().replace(
            [
                SECONDS(round(self.seconds, 1)),
                PART_SECONDS({title: round(s, 1) for title, s in self.part_seconds.items()}),
                STUDY(run),
                VERSIONS(installed_versions()),
                PENDING(list(self.pending) or None),
            ]
        )
        return ByName({other.name: other.complete() for other in further}, about)


@dataclass(frozen=True, slots=True)
class Column:
    title: str
    tables: Sequence[Table]
    figures: Sequence[Figure]


@dataclass(frozen=True, slots=True)
class Section:
    """Section of a report page. Its details are hidden until the reader opens them."""

    anchor: str
    title: str
    text: str
    figures: Sequence[Figure] = ()
    table: Table | None = None
    details: Sequence[Column] = ()

    @property
    def wide(self) -> bool:
        """True if a table has more columns than fit on half the width of the page."""
        tables = (table for column in self.details for table in column.tables)
        return any(len(table.head) > _HALF for table in tables)


@dataclass(frozen=True, slots=True)
class Page:
    """Content of a report page.

    A study sets the first fields, and :func:`render` sets the other fields.
    """

    title: str
    heading: str
    intro: str
    badges: Sequence[str]
    how: Sequence[tuple[str, Sequence[str]]]
    warning: str = ""
    outcome: Sequence[str] = ()
    claims: Table | None = None
    claims_text: str = ""
    several: bool = False
    sections: Sequence[Section] = ()
    notice: tuple[str, str] | None = None
    left_out: Sequence[tuple[str, Sequence[str]]] = ()
    command: str = ""
    versions: Mapping[str, str] | None = None

    def html(self) -> str:
        r"""Return the page as HTML. Control characters are shown as text such as ``\u001b``."""
        # Names of files, recordings and plug-ins need be neither UTF-8 nor free of escapes.
        return sanitize(_template().render(page=self))


@cache
def _template() -> Template:
    # Compiled once: a study writes its page after each step.
    from jinja2 import Environment, StrictUndefined

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    text = files("firstcontact_lab.report").joinpath("report.html").read_text(encoding="utf-8")
    return environment.from_string(text)


def render(state: State) -> str:
    page = state.page(state)
    return replace(
        page,
        warning=page.warning if state.quick else "",
        sections=[*page.sections, *sections(state.findings, state.parts)],
        notice=_notice(state),
        left_out=[(f.title, f.left_out) for f in state.findings if f.left_out],
        command=state.command,
        versions=installed_versions(),
    ).html()


def sections(all_findings: Sequence[Findings], parts: Mapping[str, Part]) -> list[Section]:
    measured = [findings for findings in all_findings if findings.results is not NOTHING]
    subjects = {findings.title: findings.results for findings in measured}
    made = (_section(name, part, subjects, measured) for name, part in parts.items())
    return [section for section in made if section is not None]


def _section(
    name: str, part: Part, subjects: Subjects, all_findings: Sequence[Findings]
) -> Section | None:
    tables = {title: part.made_tables(results) for title, results in subjects.items()}
    figures = {f.title: list(f.figures.get(name, {}).values()) for f in all_findings}
    if not any(tables.values()) and not any(figures.values()):
        return None
    drawn = list(part.figures(subjects))
    open_count = 0 if drawn else 1
    lead = [
        replace(figure, title=f"{figure.title}, {title}") if len(figures) > 1 else figure
        for title, each in figures.items()
        for figure in each[:open_count]
    ]
    first = {title: each[0] for title, each in tables.items() if each[:open_count]}
    details = [
        Column(title, tables[title][open_count:], figures[title][open_count:]) for title in tables
    ]
    return Section(
        part.name,
        part.title,
        part.text(subjects),
        figures=drawn or lead,
        table=join_side_by_side(first, part.columns) if first else None,
        details=[column for column in details if column.tables or column.figures],
    )


def _notice(state: State) -> tuple[str, str] | None:
    """Return (title, details) on the progress of an unfinished study, or None if it is finished."""
    if not state.pending:
        return None
    pending = "; ".join(state.pending)
    progress = f"{state.completed} of {len(state.steps)} parts are done."
    if state.stopped or state.interrupted:
        why = f"Stopped: {state.stopped}." if state.stopped else "Interrupted."
        return why, f"{progress} Not done: {pending}."
    return "Still running.", f"{progress} Not done yet: {pending}. Load the page again for more."
