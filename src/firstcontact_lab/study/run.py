"""Run of a whole study: sources, workers, progress, files."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from firstcontact.core import Dataset, Runner, parallel, resolve_path
from firstcontact_lab.report.findings import Findings
from firstcontact_lab.report.folder import sole_use, without_worker_warnings
from firstcontact_lab.report.state import State
from firstcontact_lab.study import _protocol as protocol
from firstcontact_lab.study._sources import CONDITIONS, check_sources, recorded, simulated
from firstcontact_lab.study.settings import StudySettings

Sources = Sequence[tuple[str, Callable[[], Dataset]]]


def run_study(
    settings: StudySettings, out: Path, recordings: Path | None, quick: bool, command: str
) -> Path:
    """Run every part of a study, and update the files after each step."""
    from tqdm import tqdm

    options = _options(settings, recordings)
    # In a log, which is no terminal, a line every ten seconds is enough.
    often = 0.1 if sys.stderr.isatty() else 10.0
    with ExitStack() as opened:
        opened.enter_context(sole_use(out, options))
        opened.enter_context(without_worker_warnings())
        check_sources(recordings, out)  # refused before a bar is drawn
        bar = opened.enter_context(tqdm(bar_format=_BAR, miniters=0, mininterval=often))
        finished = step_cost = 0.0

        def within(count: int, total: int) -> None:
            bar.update(finished + step_cost * count / total - bar.n)

        with parallel(settings.workers, within) as runner:
            sources = _sources(settings, out, recordings, runner)
            steps = protocol.plan(sources, settings, runner, _set_name(recordings))
            bar.reset(total=sum(step.cost for step in steps))
            titles = [f"{step.subject}: {step.title}" for step in steps]
            findings = [Findings(name) for name, _ in sources]
            state = State(command, asdict(settings), quick, findings, titles, options=options)

            def tick(title: str) -> None:
                nonlocal finished, step_cost
                finished = sum(step.cost for step in steps[: state.completed])
                step_cost = steps[state.completed].cost
                bar.n = finished
                bar.set_description(title)

            protocol.run(steps, state, out, tick)
            bar.n = bar.total
            bar.set_description("done")
    return out / "report.html"


def _options(settings: StudySettings, recordings: Path | None) -> dict[str, Any]:
    """Return the settings and the path of the recordings, on which the results depend."""
    data = None if recordings is None else str(resolve_path(recordings))
    sizes = {name: value for name, value in asdict(settings).items() if name != "workers"}
    return {"verb": "study", "recordings": data, **sizes}


def _set_name(recordings: Path | None) -> str:
    """Return the name of the recordings' folder or file, for results."""
    name = "" if recordings is None else resolve_path(recordings).stem
    return name.encode("utf-8", "replace").decode() or "recordings"


_BAR = "{desc}{percentage:3.0f} %|{bar}| {elapsed}, {remaining} left"


def _sources(
    settings: StudySettings, out: Path, recordings: Path | None, runner: Runner
) -> Sources:
    if recordings is not None:
        return [("recordings", lambda: recorded(recordings, out))]
    return [(name, partial(simulated, name, settings, out, runner)) for name in CONDITIONS]
