"""``firstcontact benchmark``: the parts of a study that compare a regressor with ours."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from firstcontact.cli import Option


@dataclass(frozen=True)
class Benchmark:
    """Score a regressor and the package's estimators on the same pinches.

    The pinches come from simulated rigs, or from recordings with whole sessions held out.
    """

    regressor: Annotated[str, Option(positional=True)]
    """Registered estimator, or PACKAGE:NAME of a scikit-learn regressor."""
    out: Path = Path("firstcontact-benchmark")
    """Folder for report and results; for this benchmark only."""
    recordings: Path | None = None
    """Recordings to score on, instead of simulated rigs."""
    quick: bool = False
    """Run on little data; do not quote its numbers."""
    seed: int = 0
    """Random seed of training and bootstrap intervals."""
    workers: int = 0
    """Number of processes; 0 takes all cores."""

    def run(self) -> None:
        from firstcontact_lab.verbs.study import Study

        Study(
            recordings=self.recordings,
            out=self.out,
            quick=self.quick,
            parts=("blocks", "objects", "anytime")
            if self.recordings
            else ("generalise", "anytime"),
            estimator=(self.regressor,),
            seed=self.seed,
            workers=self.workers,
        ).run()
