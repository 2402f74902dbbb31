"""``firstcontact study``: run every experiment, and write one report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import Option, choice, on_cluster
from firstcontact.contact import DETECTORS
from firstcontact.core import ArgumentError
from firstcontact.core.installation import require_modules
from firstcontact_lab.study.parts import PARTS


@dataclass(frozen=True)
class Study:
    """Run every experiment that the data permit and write report.html and results.json."""

    recordings: Path | None = None
    """Recordings, or data that `import` reads; the twin by default."""
    out: Path = Path("firstcontact-study")
    """Folder for report, results and recordings; for this study only."""
    quick: bool = False
    """Run each part on little data; do not quote its numbers."""
    parts: Annotated[tuple[str, ...], choice(PARTS)] = ()
    """Parts to run, with the parts they need; the paper's parts by default."""
    detector_type: Annotated[str, choice(DETECTORS)] = DETECTORS.default
    """Detector of the contacts at which windows start."""
    estimator: tuple[str, ...] = ()
    """Further scikit-learn estimators to score, as PACKAGE:NAME."""
    early_ms: Annotated[float, Option(advanced=True)] = 0.0
    """Longest time by which a contact may precede its label, ms."""
    delays: Annotated[Path | None, Option(advanced=True)] = None
    """File of `benchmarks/live.py --out`, to score estimates in force."""
    waveforms: Annotated[Path | None, Option(advanced=True)] = None
    """File of touches that others computed, for `--parts continuum`."""
    seed: int = 0
    """Random seed of the twin, splits, training and intervals."""
    workers: Annotated[int, Option(advanced=True, group="machine")] = 0
    """Number of processes; 0 takes all cores."""
    cluster: Annotated[str | None, Option(advanced=True, group="machine")] = None
    """Dask cluster that does the work: tcp://HOST:PORT."""

    def run(self) -> None:
        from firstcontact.jobs import worker_count
        from firstcontact.models import ESTIMATORS
        from firstcontact.models.training_plan import check_seed
        from firstcontact_lab.continuum.waveforms import compare_file
        from firstcontact_lab.study.part import StudySettings
        from firstcontact_lab.study.parts.in_force import read_delays

        require_modules("study", "matplotlib", "jinja2")
        check_seed(self.seed)
        if not 0 <= self.early_ms <= 10:
            raise ArgumentError(f"--early-ms is {self.early_ms:g}: give 0 to 10")
        for part in self.parts:
            PARTS.find(part)
        settings = StudySettings(
            parts=self.parts,
            seed=self.seed,
            workers=worker_count(self.workers),
            detector=DETECTORS.find(self.detector_type).name,
            early=1e-3 * self.early_ms,
            delays="" if self.delays is None else str(self.delays),
            waveforms="" if self.waveforms is None else str(self.waveforms),
        )
        for name in self.estimator:
            ESTIMATORS.include(name)
        if self.delays is not None:
            read_delays(self.delays)
        if self.waveforms is not None:
            if "continuum" not in self.parts:
                raise ArgumentError(
                    "--waveforms is used only in the part continuum: add it to --parts, or leave "
                    "--waveforms out"
                )
            compare_file(self.waveforms)
        if self.quick:
            settings = settings.quick()
        from firstcontact_lab.study.run import run_study

        with on_cluster(self.cluster):
            report = run_study(settings, self.out, self.recordings, self.quick)
        print(report)
