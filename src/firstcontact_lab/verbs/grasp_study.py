"""``firstcontact grasp-study``: measure how much an estimate of stiffness helps a hand."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import Option, on_cluster
from firstcontact.core.installation import require_modules


@dataclass(frozen=True)
class GraspStudy:
    """Simulate how hands pick up household objects with every policy, and write a report."""

    out: Path = Path("firstcontact-grasp-study")
    """Folder for report and results; for this study only."""
    quick: bool = False
    """Run each part on little data; do not quote its numbers."""
    seed: int = 0
    """Random seed of the twin, tuning and intervals."""
    workers: Annotated[int, Option(group="machine")] = 0
    """Number of processes; 0 takes all cores."""
    cluster: Annotated[str | None, Option(group="machine")] = None
    """Dask cluster that does the work: tcp://HOST:PORT."""

    def run(self) -> None:
        from firstcontact.jobs import worker_count
        from firstcontact.models.training_plan import check_seed

        require_modules("study", "matplotlib", "jinja2")
        check_seed(self.seed)
        from firstcontact_lab.grasping.run import GraspStudySettings, run_grasp_study

        settings = GraspStudySettings(seed=self.seed, workers=worker_count(self.workers))
        if self.quick:
            settings = settings.quick()
        with on_cluster(self.cluster):
            report = run_grasp_study(settings, self.out, self.quick)
        print(report)
