"""Progress and findings of a study, for ``results.json`` and the report."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec

from firstcontact.core import ByName, Record, installed_versions
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.results import Field, SubjectResults


class StudyRun(Record, frozen=True, kw_only=True):
    """Command, settings and progress of a study."""

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


@dataclass(slots=True)
class State:
    """Progress and findings of a study."""

    command: str
    settings: Mapping[str, Any]
    quick: bool
    findings: list[Findings]
    steps: Sequence[str]
    completed: int = 0
    interrupted: bool = False
    stopped: str = ""
    began: float = field(default_factory=time.monotonic)
    started: str = field(default_factory=lambda: time.strftime("%Y-%m-%d %H:%M %Z"))
    part_seconds: dict[str, float] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def pending(self) -> Sequence[str]:
        """Titles of the remaining steps."""
        return self.steps[self.completed :]

    @property
    def seconds(self) -> float:
        """Time since the study began, s."""
        return time.monotonic() - self.began

    def results(self) -> StudyResults:
        """Return the content of ``results.json``."""
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
        complete = _complete(first).replace(
            [
                SECONDS(round(self.seconds, 1)),
                PART_SECONDS({title: round(s, 1) for title, s in self.part_seconds.items()}),
                STUDY(run),
                VERSIONS(installed_versions()),
                PENDING(list(self.pending) or None),
            ]
        )
        return ByName({other.name: _complete(other) for other in further}, complete)


def duration(seconds: float) -> str:
    """Return a duration as text for readers."""
    complete = round(seconds)
    return f"{complete} s" if complete < 90 else f"{complete // 60} min {complete % 60:02d} s"


def _complete(findings: Findings) -> SubjectResults:
    return findings.results.replace([LEFT_OUT(findings.left_out or None)])


def named_subjects(results: StudyResults) -> dict[str, SubjectResults]:
    """Return the results of each subject, by the name of the subject."""
    run = results.about[STUDY]
    return {run.condition if run else "": results.about, **results}
