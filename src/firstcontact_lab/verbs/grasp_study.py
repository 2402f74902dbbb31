"""``firstcontact grasp-study``: what stiffness is worth to a hand, on the twin."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import one_of, where
from firstcontact.contact import DETECTORS
from firstcontact.core import InputError, require_modules
from firstcontact.models import ESTIMATORS


@dataclass(frozen=True)
class GraspStudy:
    """Pick up a household with the twin's hands and every policy; write report and results."""

    out: Path = Path("firstcontact-grasp-study")
    """Folder for report.html, results.json, the film, and the models made on the way; another
    study's results in it are not written over."""
    quick: bool = False
    """A small study of a minute: every part runs, no number is to be quoted."""
    model: Annotated[str, one_of(ESTIMATORS)] = ESTIMATORS.default
    """What learns the stiffness that policies of the older task act on."""
    detector: Annotated[str | None, one_of(DETECTORS)] = None
    """What finds contacts in the older task; left out: the usual one."""
    seed: int = 0
    """Of the twin, the trainings and the intervals."""
    workers: int = 0
    """Processes; 0 takes all cores."""
    cluster: str | None = None
    """A Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    def run(self) -> None:
        """Run the study with its progress on stderr."""
        from firstcontact.core import worker_count

        require_modules("study", "matplotlib", "jinja2", "numba")
        if self.seed < 0:
            raise InputError(f"--seed is {self.seed}: give a whole number from 0 on")
        from firstcontact_lab.grasping.run import run_grasp_study
        from firstcontact_lab.grasping.settings import GraspStudySettings

        settings = GraspStudySettings(
            model=ESTIMATORS.find(self.model).name,
            detector=None if self.detector is None else DETECTORS.find(self.detector).name,
            seed=self.seed,
            workers=worker_count(self.workers),
        )
        if self.quick:
            settings = settings.quick()
        command = shlex.join(["firstcontact", *sys.argv[1:]])
        with where(self.cluster):
            report = run_grasp_study(settings, self.out, self.quick, command)
        print(report)
