"""``firstcontact grasp-study``: measure what knowing the stiffness is worth to a hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import Option, choice, on_cluster
from firstcontact.contact import DETECTORS
from firstcontact.core.installation import require_modules
from firstcontact.models import ESTIMATORS


@dataclass(frozen=True)
class GraspStudy:
    """Simulate how hands pick up household objects with every policy, and write a report."""

    out: Path = Path("firstcontact-grasp-study")
    """Folder for report, results, film and models; for this study only."""
    quick: bool = False
    """Run each part on little data; do not quote its numbers."""
    estimator: Annotated[str, choice(ESTIMATORS)] = ESTIMATORS.default
    """Estimator of the stiffness that policies act on."""
    detector_type: Annotated[str | None, choice(DETECTORS)] = None
    """Contact detector to fit; the default detector if left out."""
    seed: int = 0
    """Random seed of the twin, training and intervals."""
    workers: Annotated[int, Option(group="machine")] = 0
    """Number of processes; 0 takes all cores."""
    cluster: Annotated[str | None, Option(group="machine")] = None
    """Dask cluster that does the work: tcp://HOST:PORT."""

    def run(self) -> None:
        """Run the study with its progress on stderr."""
        from firstcontact.core.jobs import worker_count
        from firstcontact.models.training_runs import check_seed

        require_modules("study", "matplotlib", "jinja2")
        check_seed(self.seed)
        from firstcontact_lab.grasping.run import run_grasp_study
        from firstcontact_lab.grasping.settings import GraspStudySettings

        settings = GraspStudySettings(
            model=ESTIMATORS.find(self.estimator).name,
            detector=None
            if self.detector_type is None
            else DETECTORS.find(self.detector_type).name,
            seed=self.seed,
            workers=worker_count(self.workers),
        )
        if self.quick:
            settings = settings.quick()
        with on_cluster(self.cluster):
            report = run_grasp_study(settings, self.out, self.quick)
        print(report)
