"""``firstcontact study``: every experiment, one report."""

from __future__ import annotations

import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import one_of, where
from firstcontact.contact import DETECTORS
from firstcontact.core import InputError, require_modules


@dataclass(frozen=True)
class Study:
    """Run every experiment that the data permit and write report.html and results.json."""

    recordings: Path | None = None
    """Recordings, or data that `firstcontact import` takes; without it the twin is simulated."""
    out: Path = Path("firstcontact-study")
    """Folder for the report, the results and the recordings made on the way; another study's
    results in it are not written over."""
    quick: bool = False
    """A small study of a minute: every part runs, no number is to be quoted."""
    detector: Annotated[str, one_of(DETECTORS)] = DETECTORS.default
    """What finds the contacts at which windows start; all detectors are scored."""
    estimator: tuple[str, ...] = ()
    """Regressors or classifiers in scikit-learn's form to study beside ours, as PACKAGE:NAME."""
    early_ms: float = 0.0
    """How much earlier than its label a contact may be, ms: labels from a trigger are late."""
    board: Path | None = None
    """`embedded.json` of `make embedded`: the time that models take on the hand, in the report."""
    seed: int = 0
    """Of the twin, the splits, the trainings and the intervals."""
    workers: int = 0
    """Processes; 0 takes all cores."""
    cluster: str | None = None
    """A Dask cluster that does the work instead of this machine: tcp://HOST:PORT."""

    def run(self) -> None:
        """Run the study with its progress on stderr."""
        from firstcontact.core import worker_count
        from firstcontact.models import ESTIMATORS
        from firstcontact_lab.study.parts.inference import read_board
        from firstcontact_lab.study.settings import StudySettings

        require_modules("study", "matplotlib", "jinja2")
        if self.recordings is None:
            require_modules("study", "numba")
        if self.seed < 0 or not 0 <= self.early_ms <= 10:
            raise InputError("--seed must not be negative, and --early-ms lies from 0 to 10")
        settings = StudySettings(
            seed=self.seed,
            workers=worker_count(self.workers),
            detector=DETECTORS.find(self.detector).name,
            early=1e-3 * self.early_ms,
            board="" if self.board is None else str(self.board),
        )
        for name in self.estimator:
            ESTIMATORS.include(name)
        if self.board is not None:
            read_board(self.board)
        if self.quick:
            settings = settings.quick()
        from firstcontact_lab.study.run import run_study

        command = shlex.join(["firstcontact", *sys.argv[1:]])
        with where(self.cluster):
            report = run_study(settings, self.out, self.recordings, self.quick, command)
        print(report)
