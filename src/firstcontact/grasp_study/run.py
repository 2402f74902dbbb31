"""A whole grasp study: models, search, closings, files."""

from __future__ import annotations

import sys
import time
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any

from firstcontact.core.files import write_text
from firstcontact.core.jobs import Runner, parallel
from firstcontact.grasp.grip import Grip
from firstcontact.grasp_study._film import PICTURES, film
from firstcontact.grasp_study._learning import Models, learn, loaded
from firstcontact.grasp_study._numbers import (
    by_object,
    by_policy,
    headline,
)
from firstcontact.grasp_study._report import render
from firstcontact.grasp_study._search import search
from firstcontact.grasp_study._trials import PinchSetup, Row, Trial, run_trial
from firstcontact.grasp_study.results import (
    Filmed,
    GraspData,
    GraspResults,
    GraspRun,
    ModelErrors,
    Tuning,
)
from firstcontact.grasp_study.settings import GraspStudySettings
from firstcontact.grasp_study.variants import variants
from firstcontact.report.folder import sole_use
from firstcontact.report.results.file import write_results
from firstcontact.report.state import versions


def run_grasp_study(settings: GraspStudySettings, out: Path, quick: bool, command: str) -> Path:
    """Run everything and write ``report.html``, ``results.json``, ``film.gif`` and ``grasp.png``.

    Parameters
    ----------
    settings
        Size and seed.
    out
        Folder of the study; recordings and models in it are made again.
    quick
        Whether the settings are the small ones: the report says so.
    command
        What was typed: the report says so.

    Returns
    -------
    Path
        The report.

    Raises
    ------
    InputError
        ``out`` cannot be written to, is another running study's, or holds the results of
        another one, or recordings or models that no study made.
    """
    asked = _asked(settings)
    with sole_use(out, asked):
        return _run(settings, out, quick, command, asked)


def _run(
    settings: GraspStudySettings, out: Path, quick: bool, command: str, asked: dict[str, Any]
) -> Path:
    from tqdm import tqdm

    began = time.monotonic()
    started = datetime.now().astimezone().isoformat(timespec="minutes")
    often = 0.1 if sys.stderr.isatty() else 10.0
    with tqdm(unit="job", bar_format=_BAR, miniters=0, mininterval=often) as bar:

        def stage(title: str) -> None:
            bar.reset()
            bar.set_description(title)

        def within(done: int, total: int) -> None:
            bar.total, bar.n = total, done
            bar.update(0)

        with parallel(settings.workers, within) as runner:
            stage("models")
            learned = learn(settings, out, runner)
            stage("tuning")
            found = search(settings, runner)
            stage("closings")
            models = loaded(learned.folder)
            rows = close_all(settings, found, models, runner)
            stage("film")
            tuned = {key: f.settings for key, f in found.items()}
            pictures = PICTURES // 3 if quick else PICTURES
            shown = film(
                out / "film.gif", settings.sessions, settings.seed, tuned, models, pictures
            )
    results = GraspResults(
        study=GraspRun(
            command=command,
            started=started,
            seconds=time.monotonic() - began,
            quick=quick,
            seed=settings.seed,
            workers=settings.workers,
            asked=asked,
            versions=versions(),
        ),
        data=GraspData(
            source="twin",
            objects=list(settings.kinds),
            sessions=settings.sessions,
            pinches=settings.sessions * len(settings.kinds),
            closings=len(rows),
            training=5 * settings.training,
            latencies_ms=[round(1e3 * latency, 3) for latency in settings.latencies],
        ),
        models=ModelErrors(rmse=learned.rmse, interval_width=learned.width),
        grip=asdict(Grip()),
        feedback=found,
        policies=by_policy(rows, settings.seed),
        objects=by_object(rows, settings.seed),
        headline=headline(rows, settings.seed),
        film=Filmed(object=shown.kind, session=shown.session),
    )
    write_results(out / "results.json", results)
    from firstcontact.grasp_study.figures.headline import headline_picture

    headline_picture(results.policies, results.latency, out / "grasp.png")
    report = out / "report.html"
    write_text(report, render(results, out / "film.gif"))
    return report


def close_all(
    settings: GraspStudySettings, found: dict[str, Tuning], models: Models, runner: Runner
) -> list[Row]:
    """Every policy on every pinch at every latency: same pinch, same chance."""
    tuned = {key: f.settings for key, f in found.items()}
    compared = tuple(variants().values())
    trials = [
        Trial(PinchSetup(k, s, seed=settings.seed), compared, settings.latencies, tuned)
        for s in range(settings.sessions)
        for k in settings.kinds
    ]
    return [row for rows in runner.map(run_trial, trials, models) for row in rows]


def _asked(settings: GraspStudySettings) -> dict[str, Any]:
    """What the results depend on: settings, but not how many processes."""
    sizes = {name: value for name, value in asdict(settings).items() if name != "workers"}
    return {"verb": "grasp-study", **sizes}


_BAR = "{desc}: {percentage:3.0f} %|{bar}| {n_fmt}/{total_fmt} [{elapsed}]"
