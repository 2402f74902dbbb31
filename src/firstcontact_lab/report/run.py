"""Run of a study: its locked folder, its jobs in order, and its files after each job.

The folder of another study is never overwritten.
"""

from __future__ import annotations

import fcntl
import json
import logging
import os
import shutil
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from firstcontact.core import FileError, InputError
from firstcontact.core.files import write_json, write_text
from firstcontact.jobs import Runner, parallel
from firstcontact_lab.report.findings import Findings, PartResult
from firstcontact_lab.report.page import State, render
from firstcontact_lab.report.results import read_options, write_results

_log = logging.getLogger("firstcontact_lab.report")

#: Marker file for recordings that a study made and may replace.
MARK = "made-by-study.json"
RESULTS, REPORT = "results.json", "report.html"
_REMEDY = "choose another --out, or move it away"


@contextmanager
def locked_study_folder(out: Path, options: Mapping[str, Any]) -> Iterator[None]:
    """Make the folder of a study, and lock it until the ``with`` block ends.

    Raise InputError if another study runs in this folder, or left results of other settings there.
    """
    made = not out.exists()
    try:
        out.mkdir(parents=True, exist_ok=True)
        handle = os.open(out, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    except OSError as error:
        raise FileError(f"{out} cannot be made ({error.strerror}): choose another --out") from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise FileError(
                f"another study is running in {out}: wait until it ends, or choose another --out"
            ) from None
        except OSError:
            pass  # a disk without locks
        _check_same_settings(out, options)
        yield
    except InputError:
        if made:
            with suppress(OSError):  # a folder with files in it stays
                out.rmdir()
        raise
    finally:
        os.close(handle)


def _check_same_settings(out: Path, options: Mapping[str, Any]) -> None:
    """Raise InputError if the folder has results of a study with other settings."""
    results = out / RESULTS
    if not results.exists():
        if (out / REPORT).exists():
            raise FileError(f"{out / REPORT} was not made by a study: {_REMEDY}")
        return
    try:
        existing = read_options(results, _REMEDY)
    except (InputError, OSError):
        raise FileError(f"{results} was not made by a study of this version: {_REMEDY}") from None
    mine = json.loads(json.dumps(options))
    if existing != mine:
        differs = sorted(k for k in {*existing, *mine} if existing.get(k) != mine.get(k))
        raise FileError(
            f"{out} holds the results of another study (other {', '.join(differs)}): choose "
            "another --out, or remove it"
        )


def empty_marked_folder(directory: Path, mark: Mapping[str, object]) -> Path:
    """Empty ``directory``, mark it as made by a study, and return it.

    ``mark`` is the content of the file that marks it. Raise FileError if the folder exists without
    such a file.
    """
    check_marked_folder(directory)
    if directory.exists():
        shutil.rmtree(directory)
    write_json(directory / MARK, mark)
    return directory


def check_marked_folder(directory: Path) -> None:
    """Raise InputError if the folder exists and was not made by :func:`empty_marked_folder`."""
    if directory.exists() and not (directory / MARK).exists():
        raise FileError(f"{directory} was not made by a study: {_REMEDY}")


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """One measurement of a study on one dataset. If a *vital* job fails, the study ends."""

    subject: str
    part: str
    title: str
    run: Callable[[], PartResult]
    vital: bool = False
    cost: float = 1.0

    @property
    def name(self) -> str:
        return f"{self.subject}: {self.title}"

    def measure(self) -> PartResult:
        """Run the job, and return what it measured.

        If the data do not permit the measurement, return a result that holds only the reason. For a
        vital job, raise InputError instead.
        """
        try:
            return self.run()
        except InputError as error:
            if self.vital:
                raise
            _log.info("%s left out: %s", self.name, error)
            return PartResult(left_out=[f"{self.title[:1].upper() + self.title[1:]}: {error}."])


def run_steps(
    out: Path,
    state: State,
    workers: int,
    plan: Callable[[Runner], list[Job]],
    check: Callable[[], object] = lambda: None,
) -> Path:
    from tqdm import tqdm

    with ExitStack() as opened:
        opened.enter_context(locked_study_folder(out, state.options))
        opened.enter_context(warnings.catch_warnings())
        # Other workers take the jobs of a worker that ended early.
        warnings.filterwarnings("ignore", "A worker stopped while some jobs", UserWarning)
        check()
        bar = opened.enter_context(tqdm(bar_format=_BAR, miniters=0, disable=None))
        finished = step_cost = 0.0

        def within(count: int, total: int) -> None:
            bar.update(finished + step_cost * count / total - bar.n)

        def describe(words: str) -> None:
            bar.set_description(words)
            if bar.disable:  # a pipe or a log
                print(f"{100 * bar.n / bar.total:3.0f} % {words}", file=sys.stderr)

        with parallel(workers, within) as runner:
            jobs = plan(runner)
            bar.reset(total=sum(job.cost for job in jobs))

            def tick(job: Job) -> None:
                nonlocal finished, step_cost
                finished = bar.n = sum(done.cost for done in jobs[: state.completed])
                step_cost = job.cost
                describe(job.name)

            run_jobs(jobs, state, out, tick)
            bar.n = bar.total
            describe("done")
    return out / REPORT


_BAR = "{desc}{percentage:3.0f} %|{bar}| {elapsed}, {remaining} left"


def run_jobs(
    jobs: Sequence[Job], state: State, out: Path, tick: Callable[[Job], object] = lambda job: None
) -> None:
    """Run all jobs, and write ``report.html`` and ``results.json`` after each job.

    Then call ``tick`` with the job.
    """
    state.steps = [job.name for job in jobs]
    by_name = {name: Findings(name) for name in dict.fromkeys(job.subject for job in jobs)}
    state.findings = list(by_name.values())
    title = ""
    try:
        for job in jobs:
            title = job.name
            tick(job)
            began = time.monotonic()
            by_name[job.subject].add(job.part, job.measure())
            state.part_seconds[title] = time.monotonic() - began
            state.completed += 1
            write(state, out)
    except KeyboardInterrupt:
        state.interrupted = True
        if state.completed:
            write(state, out)
        raise
    except Exception as error:
        state.stopped = f"{title}: {str(error) or type(error).__name__}"
        if state.completed:
            # Show the error that ended the study, not an error while the report is written.
            with suppress(OSError):
                write(state, out)
        raise


def write(state: State, out: Path) -> None:
    write_results(out / RESULTS, state.results())
    write_text(out / REPORT, render(state))
