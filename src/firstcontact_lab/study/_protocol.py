"""The parts in their order, and the files that are written again after each."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from firstcontact.core import Dataset, ForeignCode, InputError, Runner, missing_modules, write_text
from firstcontact.models import ESTIMATORS, window_estimators
from firstcontact_lab.report.findings import Findings, PartResult
from firstcontact_lab.report.results.file import write_results
from firstcontact_lab.report.state import State
from firstcontact_lab.study._subject import Subject
from firstcontact_lab.study.parts.answer_time import answer_time
from firstcontact_lab.study.parts.anytime import anytime
from firstcontact_lab.study.parts.blocks import blocks
from firstcontact_lab.study.parts.contacts import contacts
from firstcontact_lab.study.parts.data import describe
from firstcontact_lab.study.parts.generalise import generalise
from firstcontact_lab.study.parts.hardness import hardness
from firstcontact_lab.study.parts.inference import inference
from firstcontact_lab.study.parts.objects import objects
from firstcontact_lab.study.parts.second_contact import second_contact
from firstcontact_lab.study.parts.short_windows import short_windows
from firstcontact_lab.study.parts.waveforms import waveforms
from firstcontact_lab.study.parts.window_length import window_length
from firstcontact_lab.study.settings import StudySettings


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One part for one subject.

    Parameters
    ----------
    subject
        Name of the subject.
    title
        For the progress bar and the report.
    run
        Does it.
    vital
        Whether the study ends where it cannot be done.
    """

    subject: str
    title: str
    run: Callable[[], PartResult]
    vital: bool = False


def plan(
    sources: Sequence[tuple[str, Callable[[], Dataset]]],
    settings: StudySettings,
    runner: Runner,
    set_name: str = "recordings",
) -> list[Step]:
    """All steps: what is quick for every subject first, then what takes long.

    Parameters
    ----------
    sources
        Name of each subject, and what loads it.
    settings
        Size of the study.
    runner
        Where trainings run.
    set_name
        What recordings are called in the results.
    """
    subjects: dict[str, Subject] = {}
    found = window_estimators().items()
    able = [name for name, entry in found if not missing_modules(entry.modules)]
    fast = [name for name in able if not ESTIMATORS[name].slow]
    slow = [name for name in able if ESTIMATORS[name].slow]
    titles = {True: _titles(slow), False: _titles(fast)}

    def step(name: str, title: str, part: Callable[[Subject], PartResult]) -> Step:
        return Step(name, title, lambda: part(subjects[name]))

    steps = []
    for name, load in sources:

        def opened(name: str = name, load: Callable[[], Dataset] = load) -> PartResult:
            subjects[name] = Subject(name, load(), set_name=set_name)
            return describe(subjects[name])

        steps += [
            Step(name, "data", opened, vital=True),
            step(name, "contact detection", lambda s: contacts(s, settings, runner)),
            step(name, "time to an answer", lambda s: answer_time(s, settings)),
            step(name, "waveforms", waveforms),
            step(name, f"blocks: {titles[False]}", lambda s: blocks(s, settings, runner, fast)),
            step(name, f"objects: {titles[False]}", lambda s: objects(s, settings, runner, fast)),
            step(name, "answers at any time", lambda s: anytime(s, settings)),
            step(name, "hardness order", lambda s: _ranked(hardness, s, settings, runner)),
            step(name, "short windows", lambda s: _ranked(short_windows, s, settings, runner)),
        ]
    for name, _ in sources:
        steps += [
            step(name, "off the blocks", lambda s: generalise(s, settings, runner)),
            step(name, "window length", lambda s: window_length(s, settings, runner)),
            step(name, f"objects: {titles[True]}", lambda s: objects(s, settings, runner, slow)),
            step(name, f"blocks: {titles[True]}", lambda s: blocks(s, settings, runner, slow)),
            step(name, "second contact", lambda s: second_contact(s, settings)),
            step(name, "inference time", lambda s: inference(s, settings)),
        ]
    return steps


def _titles(estimators: Sequence[str]) -> str:
    """Of what is used, and of floors only that there are some."""
    kinds = [ESTIMATORS[name] for name in estimators]
    floors = ["baselines"] if any(kind.baseline for kind in kinds) else []
    return ", ".join([kind.title for kind in kinds if not kind.baseline] + floors)


def _ranked(
    part: Callable[[Subject, StudySettings, Runner], PartResult],
    subject: Subject,
    settings: StudySettings,
    runner: Runner,
) -> PartResult:
    """A part that needs hardness ranks, where there are some."""
    if not np.isfinite(subject.dataset.hardness_rank).any():
        return PartResult()
    return part(subject, settings, runner)


def run(
    steps: Sequence[Step],
    state: State,
    out: Path,
    tick: Callable[[str], object] = lambda title: None,
) -> None:
    """Do all steps; after each, ``report.html`` and ``results.json`` are whole and newer.

    Parameters
    ----------
    steps
        From :func:`plan`.
    state
        Takes what is found.
    out
        Folder of the two files.
    tick
        Called with the title of each step before it begins.

    Raises
    ------
    InputError
        The data of a subject cannot be used. In any other part it becomes a
        sentence among what was left out, and the study goes on.
    Exception
        Whatever else a part raises; the report then says where it stopped.
    """
    by_name: dict[str, Findings] = {f.name: f for f in state.findings}
    title = ""
    try:
        for step in steps:
            title = f"{step.subject}: {step.title}"
            tick(title)
            began = time.monotonic()
            by_name[step.subject].take(_done(step))
            state.part_seconds[title] = time.monotonic() - began
            state.done += 1
            write(state, out)
    except KeyboardInterrupt:
        state.interrupted = True
        if state.done:
            write(state, out)
        raise
    except Exception as error:
        state.stopped = f"{title}: {str(error) or type(error).__name__}"
        if state.done:
            # What ended the study is to be read, not what went wrong after it.
            with suppress(OSError):
                write(state, out)
        raise


def _done(step: Step) -> PartResult:
    try:
        with ForeignCode():
            return step.run()
    except InputError as error:
        if step.vital:
            raise
        return PartResult(left_out=[f"{step.title[:1].upper() + step.title[1:]}: {error}."])


def write(state: State, out: Path) -> None:
    """Write both files as the study stands."""
    from firstcontact_lab.report.page import render

    write_results(out / "results.json", state.results())
    write_text(out / "report.html", render(state))
