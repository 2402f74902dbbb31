"""Order of the steps of a study, and the files that are written after each step."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from firstcontact.core import Dataset, InputError, Runner, write_text
from firstcontact_lab.report.findings import Findings, PartResult
from firstcontact_lab.report.results import write_results
from firstcontact_lab.report.state import State
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.page import render
from firstcontact_lab.study.part import Step
from firstcontact_lab.study.parts import chosen_parts
from firstcontact_lab.study.settings import StudySettings


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """One step of a part for one subject."""

    subject: str
    part: str
    title: str
    run: Callable[[], PartResult]
    vital: bool = False
    cost: float = 1.0


def plan(
    sources: Sequence[tuple[str, Callable[[], Dataset]]],
    settings: StudySettings,
    runner: Runner,
    set_name: str = "recordings",
) -> list[Job]:
    """Return all jobs of a study: first the quick steps of every subject, then the slow ones."""
    subjects: dict[str, Subject] = {}

    def job(name: str, load: Callable[[], Dataset], part: str, step: Step) -> Job:
        def measure() -> PartResult:
            if name not in subjects:
                subjects[name] = Subject(name, load(), set_name=set_name)
            return step.run(subjects[name], settings, runner)

        return Job(name, part, step.title, measure, step.vital, step.cost)

    return [
        job(name, load, part, step)
        for late in (False, True)
        for name, load in sources
        for part, entry in chosen_parts(settings.parts).items()
        for step in entry.steps
        if step.late == late
    ]


def run(
    steps: Sequence[Job],
    state: State,
    out: Path,
    tick: Callable[[str], object] = lambda title: None,
    page: Callable[[State], str] = render,
) -> None:
    """Run all jobs. Write ``report.html`` and ``results.json`` after each job."""
    by_name: dict[str, Findings] = {f.name: f for f in state.findings}
    title = ""
    try:
        for step in steps:
            title = f"{step.subject}: {step.title}"
            tick(title)
            began = time.monotonic()
            by_name[step.subject].add(step.part, _measure(step))
            state.part_seconds[title] = time.monotonic() - began
            state.completed += 1
            write(state, out, page)
    except KeyboardInterrupt:
        state.interrupted = True
        if state.completed:
            write(state, out, page)
        raise
    except Exception as error:
        state.stopped = f"{title}: {str(error) or type(error).__name__}"
        if state.completed:
            # Show the error that ended the study, not an error while the report is written.
            with suppress(OSError):
                write(state, out, page)
        raise


def _measure(step: Job) -> PartResult:
    try:
        return step.run()
    except InputError as error:
        if step.vital:
            raise
        return PartResult(left_out=[f"{step.title[:1].upper() + step.title[1:]}: {error}."])


def write(state: State, out: Path, page: Callable[[State], str] = render) -> None:
    """Write the report and the results of a study so far."""
    write_results(out / "results.json", state.results())
    write_text(out / "report.html", page(state))
