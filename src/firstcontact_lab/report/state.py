"""What a study has found so far, as ``results.json`` and the report show it."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from msgspec.structs import asdict, replace

from firstcontact.core import ByName, installed_versions
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.results.study import (
    FirstSubject,
    StudyResults,
    StudyRun,
    SubjectResults,
)


@dataclass(slots=True)
class State:
    """A study on its way.

    Parameters
    ----------
    command
        What was typed.
    settings
        Sizes and seeds.
    quick
        Whether it is the small form, whose numbers are not to be quoted.
    findings
        One a subject; the first is the top level of ``results.json``.
    steps
        Titles of all parts, in order.
    done
        How many of them are done.
    interrupted
        Whether it was ended from outside.
    stopped
        The part that ended it and its error, else empty.
    asked
        What the results depend on: the folder of the study is kept from others by it.
    """

    command: str
    settings: Mapping[str, Any]
    quick: bool
    findings: list[Findings]
    steps: Sequence[str]
    done: int = 0
    interrupted: bool = False
    stopped: str = ""
    began: float = field(default_factory=time.monotonic)
    started: str = field(default_factory=lambda: time.strftime("%Y-%m-%d %H:%M %Z"))
    part_seconds: dict[str, float] = field(default_factory=dict)
    asked: Mapping[str, Any] = field(default_factory=dict)

    @property
    def pending(self) -> Sequence[str]:
        """Titles of the parts that are not done."""
        return self.steps[self.done :]

    @property
    def seconds(self) -> float:
        """Time since the study began, s."""
        return time.monotonic() - self.began

    def results(self) -> StudyResults:
        """``results.json``: the first subject at the top, others under their names."""
        first, *others = self.findings
        run = StudyRun(
            command=self.command,
            condition=first.name,
            quick=self.quick,
            started=self.started,
            complete=not self.pending,
            stopped=self.stopped or None,
            asked=dict(self.asked),
            settings=dict(self.settings),
            seed=self.settings["seed"],
        )
        whole = FirstSubject(
            **asdict(_told(first)),
            seconds=round(self.seconds, 1),
            part_seconds={k: round(v, 1) for k, v in self.part_seconds.items()},
            study=run,
            versions=installed_versions(),
            pending=list(self.pending) or None,
        )
        return ByName({other.name: _told(other) for other in others}, whole)


def _told(findings: Findings) -> SubjectResults:
    """With what was left out."""
    return replace(findings.results, left_out=findings.left_out or None)
