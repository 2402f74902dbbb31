"""Definition of a study part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from firstcontact.core import Runner
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import Field, SubjectResults
from firstcontact_lab.report.tables import Row, Table
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

T = TypeVar("T")
#: Results of each subject by the title of the subject.
Subjects = Mapping[str, SubjectResults]
#: Measurement of a subject.
Measure = Callable[[Subject, StudySettings, Runner], PartResult]


@dataclass(frozen=True, slots=True)
class Step:
    """One measurement of a part of a study.

    Parameters
    ----------
    title
        Title for the progress bar and the report.
    run
        Function that measures a subject, and returns the result.
    late
        True for a slow step. Slow steps run last, after the other steps of all subjects.
    vital
        True if the study ends when the step fails.
    cost
        Time that the step takes, relative to other steps. It serves to estimate the remaining time.
    """

    title: str
    run: Measure
    late: bool = False
    vital: bool = False
    cost: float = 1.0


def with_ranks(measure: Measure) -> Measure:
    """Return a measurement that does nothing if no pinch of the subject has a hardness rank."""

    def measure_ranks(subject: Subject, settings: StudySettings, runner: Runner) -> PartResult:
        if not np.isfinite(subject.dataset.hardness_rank).any():
            return PartResult()
        return measure(subject, settings, runner)

    return measure_ranks


def no_text(subjects: Subjects) -> str:
    """Return "", the text of a part without an introduction."""
    return ""


def no_rows(subjects: Subjects) -> Sequence[Row[SubjectResults]]:
    """Return (), the row definitions of a part without any."""
    return ()


def no_figures(subjects: Subjects) -> Sequence[Figure]:
    """Return (), the figures of a part that draws none from the results of all subjects."""
    return ()


@dataclass(frozen=True, slots=True)
class Part:
    """Part of a study: measurement, figures, tables, rows and text for one topic.

    The report, ``results.json`` and the tables in the docs iterate over the registered parts.

    Parameters
    ----------
    name
        Name in the registry and in links to the section.
    title
        Heading of the section in the report.
    steps
        Measurements, in order.
    text
        Function that returns the introduction to the section, from the results so far.
    tables
        Functions that make tables of one subject. They return None or a table without lines if
        the subject has no such results. In the first open table, subjects are side by side.
    rows
        Function that returns row definitions: numbers for the docs tables, the README and the
        top of the report.
    columns
        Columns of the first table that the report shows; all if empty.
    figures
        Function that draws a figure of each subject from the results. If it returns none, the
        report shows the first figure and the first table of each subject. All other figures and
        tables are hidden until opened.
    needs
        Names of parts whose results the measurements use. These parts run first.
    by_default
        True if a study without a choice of parts includes the part.
    """

    name: str
    title: str
    steps: Sequence[Step]
    text: Callable[[Subjects], str] = no_text
    tables: Sequence[Callable[[SubjectResults], Table | None]] = ()
    rows: Callable[[Subjects], Sequence[Row[SubjectResults]]] = no_rows
    columns: Sequence[str] = ()
    figures: Callable[[Subjects], Sequence[Figure]] = no_figures
    needs: Sequence[str] = ("data", "contacts")
    by_default: bool = True

    def made_tables(self, results: SubjectResults) -> list[Table]:
        """Return the tables of one subject that have lines."""
        made = (make(results) for make in self.tables)
        return [table for table in made if table and table.lines]


def titled(subjects: Subjects, field: Field[T | None], draw: Callable[[T], Figure]) -> list[Figure]:
    """Return a figure of each subject that has this result, with the subject in the title."""
    present = {
        title: value for title, results in subjects.items() if (value := results[field]) is not None
    }
    return [
        replace(figure, title=f"{figure.title}, {title}")
        for title, value in present.items()
        for figure in (draw(value),)
    ]


def distinct(values: Iterable[str]) -> list[str]:
    """Return the distinct values in order of first occurrence."""
    return list(dict.fromkeys(values))
