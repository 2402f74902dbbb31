"""Results, figures and omitted measurements of a study, by dataset, for its report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from firstcontact.core import Record
from firstcontact.core.records import ByName
from firstcontact_lab.report.results import NOTHING, Entry, Field, SubjectResults


@dataclass(frozen=True, slots=True)
class Figure:
    key: str
    title: str
    caption: str
    image: str


@dataclass(frozen=True, slots=True)
class PartResult:
    entries: Sequence[Entry] = ()
    figures: Sequence[Figure] = ()
    left_out: Sequence[str] = ()

    @property
    def results(self) -> SubjectResults:
        """Results that this part of a study measured, without results of other parts."""
        return NOTHING.replace(self.entries) if self.entries else NOTHING


def missing(reason: str) -> PartResult:
    return PartResult(left_out=[reason])


@dataclass(slots=True)
class Findings:
    """Results, figures and omitted measurements of one dataset under study (subject)."""

    name: str
    results: SubjectResults = NOTHING
    figures: dict[str, dict[str, Figure]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    @property
    def title(self) -> str:
        return self.name.replace("-", " ").capitalize()

    def add(self, part: str, result: PartResult) -> None:
        self.results = self.results.replace(result.entries)
        figures = self.figures.setdefault(part, {})
        for figure in result.figures:
            figures.pop(figure.key, None)
            figures[figure.key] = figure
        self.left_out += [why for why in result.left_out if why not in self.left_out]

    def complete(self) -> SubjectResults:
        return self.results.replace([LEFT_OUT(self.left_out or None)])


class StudyRun(Record, frozen=True, kw_only=True):
    command: str
    condition: str
    quick: bool
    started: str
    complete: bool
    stopped: str | None = None
    options: dict[str, Any] | None = msgspec.field(default=None, name="asked")
    settings: dict[str, Any]
    seed: int


LEFT_OUT = Field.optional("left_out", list[str])
#: Fields of the first subject, about the whole study.
SECONDS = Field.optional("seconds", float)
PART_SECONDS = Field.optional("part_seconds", dict[str, float])
STUDY = Field.optional("study", StudyRun)
VERSIONS = Field.optional("versions", dict[str, str])
PENDING = Field.optional("pending", list[str])

#: Content of ``results.json``: the first subject at the top, the others under their names.
StudyResults = ByName[SubjectResults, SubjectResults]


def named_subjects(results: StudyResults) -> dict[str, SubjectResults]:
    run = results.about[STUDY]
    return {run.condition if run else "": results.about, **results}
