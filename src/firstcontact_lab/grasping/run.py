"""Run of a whole grasp study: closings, tuned policies, and files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from firstcontact.core.jobs import Runner
from firstcontact_lab.grasping._film import KINDS, PICTURES, film
from firstcontact_lab.grasping._household import HouseholdStudy
from firstcontact_lab.grasping.page import (
    FILM,
    GRASP_PARTS,
    HOUSEHOLD,
    film_figure,
    fronts_figure,
    fronts_picture,
    grasp_page,
)
from firstcontact_lab.grasping.settings import GraspStudySettings
from firstcontact_lab.report.findings import PartResult, State
from firstcontact_lab.report.run import Job, run_steps


def run_grasp_study(settings: GraspStudySettings, out: Path, quick: bool) -> Path:
    """Run a grasp study. Write its report, results, film and figure, and return the report."""
    sizes = asdict(settings)
    state = State(
        settings=sizes,
        options={"verb": "grasp-study", **{k: v for k, v in sizes.items() if k != "workers"}},
        parts=GRASP_PARTS,
        page=grasp_page,
        quick=quick,
    )
    pictures = PICTURES // 3 if quick else PICTURES
    return run_steps(out, state, settings.workers, lambda r: _jobs(settings, out, pictures, r))


def _jobs(settings: GraspStudySettings, out: Path, pictures: int, runner: Runner) -> list[Job]:
    household = HouseholdStudy(settings, runner)

    def judge() -> PartResult:
        results = household.results()
        fronts_picture(results, out / "grasp.png")
        return PartResult([HOUSEHOLD(results)], [fronts_figure(results)])

    def make_film() -> PartResult:
        kinds = [k for k in KINDS if k in settings.kinds] or [settings.kinds[0], settings.kinds[-1]]
        hand, specimen = household.judged_hands[0], settings.judged_specimens[0]
        path = out / "film.gif"
        filmed = film(path, kinds, hand, specimen, household.filmed(), household.hands, pictures)
        return PartResult([FILM(filmed)], [film_figure(filmed, path)])

    def job(part: str, title: str, run: Callable[[], PartResult | None], cost: float) -> Job:
        return Job("twin", part, title, lambda: run() or PartResult(), vital=True, cost=cost)

    return [
        job("household", "own hands", household.adapt_hands, 20),
        job("household", "closings to tune on", household.simulate_tuning, 25),
        job("household", "closings to judge", household.simulate_judged, 60),
        job("household", "tuning", household.tune, 15),
        job("household", "full closings", household.close, 20),
        job("household", "controls", judge, 30),
        job("film", "film", make_film, 10),
    ]
