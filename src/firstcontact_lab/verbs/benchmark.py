"""``firstcontact benchmark``: compare a regressor with ours, on simulated rigs or recordings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from firstcontact.cli import Option
from firstcontact.core import InputError
from firstcontact.core.installation import require_modules


@dataclass(frozen=True)
class Benchmark:
    """Score a regressor, the default one and the network on the same pinches.

    The pinches come from simulated rigs, or from recordings with whole sessions held out.
    """

    regressor: Annotated[str, Option(positional=True)]
    """Registered estimator, or PACKAGE:NAME of a scikit-learn regressor."""
    out: Path = Path("firstcontact-benchmark")
    """Folder for report and results; earlier ones are replaced."""
    recordings: Path | None = None
    """Recordings to score on, instead of simulated rigs."""
    condition: Annotated[
        Literal["paper-rig", "everyday"] | None, Option(group="simulated hand")
    ] = None
    """Condition of the simulated hand; by default all of them."""
    quick: bool = False
    """Run on little data; do not quote its numbers."""
    seed: int = 0
    """Random seed of training and bootstrap intervals."""
    workers: int = 0
    """Number of processes; 0 takes all cores."""

    def run(self) -> None:
        from firstcontact.core.jobs import worker_count
        from firstcontact.models.training_runs import check_seed
        from firstcontact.twin import CONDITIONS

        require_modules("study", "matplotlib", "jinja2")
        check_seed(self.seed)
        if self.recordings is not None and (self.condition is not None or self.quick):
            raise InputError(
                "--condition and --quick are for simulated rigs: leave them out, or leave "
                "--recordings out"
            )
        from firstcontact_lab.study.benchmark import run_benchmark

        for line in run_benchmark(
            self.regressor,
            self.out,
            self.recordings,
            [self.condition] if self.condition else list(CONDITIONS),
            self.quick,
            self.seed,
            worker_count(self.workers),
        ):
            print(line)
        print(self.out / "report.html")
