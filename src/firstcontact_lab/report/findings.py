"""Findings of a study by subject, its progress, and the content of ``results.json``."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import msgspec

from firstcontact.core import Record
from firstcontact.core.installation import installed_versions
from firstcontact.core.records import ByName
from firstcontact_lab.report.results import NOTHING, Entry, Field, SubjectResults

if TYPE_CHECKING:
    from firstcontact_lab.report.page import Page
    from firstcontact_lab.study.part import Part


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
        """Results that contain the entries of this part and nothing else."""
        return NOTHING.replace(self.entries) if self.entries else NOTHING


def missing(reason: str) -> PartResult:
    return PartResult(left_out=[reason])


@dataclass(slots=True)
class Findings:
    """Findings of one subject (dataset under study)."""

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


@dataclass(slots=True, kw_only=True)
class State:
    """Progress and findings of a study, its parts, and the function that makes its page."""

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
        """Time since the study began, s."""
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


def named_subjects(results: StudyResults) -> dict[str, SubjectResults]:
    run = results.about[STUDY]
    return {run.condition if run else "": results.about, **results}
