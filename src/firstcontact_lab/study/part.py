"""Definition of a study part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from firstcontact.core import Runner
from firstcontact_lab.report.findings import Figure, PartResult
from firstcontact_lab.report.results import SubjectResults
from firstcontact_lab.report.tables import Row, Table
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.settings import StudySettings

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


def no_figure(subjects: Subjects) -> Figure | None:
    """Return None, the figure of a part without one."""
    return None


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
        Functions that make tables of one subject. They return None if the subject has no such
        results. The report shows the first table with the subjects side by side, and hides the
        other tables until the reader opens them.
    rows
        Function that returns row definitions: numbers for the docs tables, the README and the
        comparison with the paper.
    columns
        Columns of the first table that the report shows; all if empty.
    figure
        Function that draws one figure of all subjects. If it returns None, the report shows the
        first figure of each subject. Other figures are hidden until opened.
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
    figure: Callable[[Subjects], Figure | None] = no_figure
    needs: Sequence[str] = ("data", "contacts")
    by_default: bool = True


def per_subject(subjects: Subjects, describe: Callable[[SubjectResults], str | None]) -> list[str]:
    """Return "title: description" for each subject for which ``describe`` returns a text."""
    texts = ((title, describe(results)) for title, results in subjects.items())
    return [f"{title}: {text}" for title, text in texts if text]


def distinct(values: Iterable[str]) -> list[str]:
    """Return the distinct values in order of first occurrence."""
    return list(dict.fromkeys(values))
