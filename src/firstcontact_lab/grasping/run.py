"""Run of a whole grasp study: training, search for settings, closings, and files."""

from __future__ import annotations

import sys
import time
from dataclasses import asdict
from datetime import datetime
from pathlib import Path
from typing import Any

from firstcontact.core import Runner, installed_versions, parallel, write_text
from firstcontact.models import Model
from firstcontact_lab.grasping._film import KINDS, PICTURES, film
from firstcontact_lab.grasping._household import HouseholdWork, household
from firstcontact_lab.grasping._household_numbers import baseline, candidate
from firstcontact_lab.grasping._learning import held_out_errors, learn
from firstcontact_lab.grasping._numbers import by_policy
from firstcontact_lab.grasping._search import search
from firstcontact_lab.grasping._trials import PinchSetup, Row, Trial, run_trial
from firstcontact_lab.grasping._variants import variants
from firstcontact_lab.grasping.chapters import render
from firstcontact_lab.grasping.results import (
    Filmed,
    GraspData,
    GraspResults,
    GraspRun,
    Payload,
    Tuning,
)
from firstcontact_lab.grasping.settings import GraspStudySettings
from firstcontact_lab.report.folder import sole_use, without_worker_warnings
from firstcontact_lab.report.results import write_results


def run_grasp_study(settings: GraspStudySettings, out: Path, quick: bool, command: str) -> Path:
    """Run a grasp study. Write its report, results, film and figure, and return the report."""
    options = _options(settings)
    with sole_use(out, options), without_worker_warnings():
        return _run(settings, out, quick, command, options)


def _run(
    settings: GraspStudySettings, out: Path, quick: bool, command: str, options: dict[str, Any]
) -> Path:
    from tqdm import tqdm

    began = time.monotonic()
    started = datetime.now().astimezone().isoformat(timespec="minutes")
    often = 0.1 if sys.stderr.isatty() else 10.0
    with tqdm(unit="job", bar_format=_BAR, miniters=0, mininterval=often) as bar:

        def stage(title: str) -> None:
            bar.reset()
            bar.set_description(title)

        def within(count: int, total: int) -> None:
            bar.total, bar.n = total, count
            bar.update(0)

        stage("models")
        model = learn(settings, out)  # starts and ends its own workers
        with parallel(settings.workers, within) as runner:
            work = household(settings.household, settings.seed, runner, stage)
            stage("film")
            filmed = _filmed(out / "film.gif", work, settings, PICTURES // 3 if quick else PICTURES)
            stage("payload")
            payload = _payload(settings, model, runner)
    results = GraspResults(
        study=GraspRun(
            command=command,
            started=started,
            seconds=time.monotonic() - began,
            quick=quick,
            seed=settings.seed,
            workers=settings.workers,
            options=options,
            versions=installed_versions(),
        ),
        household=work.results,
        payload=payload,
        film=filmed,
    )
    write_results(out / "results.json", results)
    from firstcontact_lab.grasping.figures import fronts_picture

    fronts_picture(results.household, out / "grasp.png")
    report = out / "report.html"
    write_text(report, render(results, out / "film.gif"))
    return report


def _filmed(path: Path, work: HouseholdWork, settings: GraspStudySettings, pictures: int) -> Filmed:
    sizes = settings.household
    kinds = [k for k in KINDS if k in sizes.kinds] or [sizes.kinds[0], sizes.kinds[-1]]
    hand, specimen = sizes.hand_seeds(settings.seed)[1][0], sizes.judged_specimens[0]
    filmed = {p.name: work.chosen[p.name] for p in (baseline(), candidate())}
    return film(path, kinds, hand, specimen, filmed, work.hands, pictures)


def _payload(settings: GraspStudySettings, model: Model, runner: Runner) -> Payload:
    """Run the payload task."""
    tuned = search(settings, runner)
    rows = close_all(settings, tuned, model, runner)
    return Payload(
        data=GraspData(
            source="twin",
            objects=list(settings.kinds),
            sessions=settings.sessions,
            pinches=settings.sessions * len(settings.kinds),
            closings=len(rows),
            training=5 * settings.training,
            latencies_ms=[round(1e3 * latency, 3) for latency in settings.latencies],
        ),
        models=held_out_errors(model),
        feedback=tuned,
        policies=by_policy(rows, settings.seed),
    )


def close_all(
    settings: GraspStudySettings, work: dict[str, Tuning], model: Model, runner: Runner
) -> list[Row]:
    """Simulate each variant on each pinch at each latency of the drive."""
    tuned = {key: f.settings for key, f in work.items()}
    compared = tuple(variants().values())
    trials = [
        Trial(PinchSetup(k, s, seed=settings.seed), compared, settings.latencies, tuned)
        for s in range(settings.sessions)
        for k in settings.kinds
    ]
    return [row for rows in runner.map(run_trial, trials, model) for row in rows]


def _options(settings: GraspStudySettings) -> dict[str, Any]:
    """Return the settings that the results depend on, without the number of processes."""
    sizes = {name: value for name, value in asdict(settings).items() if name != "workers"}
    return {"verb": "grasp-study", **sizes}


_BAR = "{desc}: {percentage:3.0f} %|{bar}| {elapsed}, {remaining} left"
