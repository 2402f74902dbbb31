"""``firstcontact grasp-study``: what grasp modulation saves on the twin."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path

from firstcontact.cli.cluster import where
from firstcontact.core.errors import InputError
from firstcontact.core.extras import need


@dataclass(frozen=True)
class GraspStudy:
    """Close the twin's hand with every policy on the same pinches; write report and results."""

    out: Path = Path("firstcontact-grasp-study")
    """Folder for report.html, results.json, the film, and the models made on the way; another
    study's results in it are not written over."""
    quick: bool = False
    """A small study of a minute: every part runs, no number is to be quoted."""
    seed: int = 0
    """Of the twin, the trainings and the intervals."""
    workers: int = 0
    """Processes; 0 takes all cores."""
    cluster: str | None = None
    """A Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    def run(self) -> None:
        """Run the study with its progress on stderr."""
        from firstcontact.core.jobs import cores

        need("study", "matplotlib", "jinja2", "numba")
        if self.seed < 0 or self.workers < 0:
            raise InputError("--seed and --workers must not be negative")
        from firstcontact.grasp_study.run import run_grasp_study
        from firstcontact.grasp_study.settings import Settings

        settings = Settings(seed=self.seed, workers=self.workers or cores())
        if self.quick:
            settings = settings.quick()
        command = shlex.join(["firstcontact", *sys.argv[1:]])
        with where(self.cluster):
            report = run_grasp_study(settings, self.out, self.quick, command)
        print(report)
