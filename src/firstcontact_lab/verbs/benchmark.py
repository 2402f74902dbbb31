"""``firstcontact benchmark``: compare a regressor with ours, on simulated rigs or recordings."""

from __future__ import annotations

import shlex
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from firstcontact.cli import Option
from firstcontact.core import InputError, require_modules


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
        """Run the benchmark, print the tables and write the report."""
        from firstcontact.core import parallel, worker_count
        from firstcontact.models import check_seed

        require_modules("study", "matplotlib", "jinja2")
        check_seed(self.seed)
        if self.recordings is not None and (self.condition is not None or self.quick):
            raise InputError(
                "--condition and --quick are for simulated rigs: leave them out, or leave "
                "--recordings out"
            )
        from firstcontact.core import installed_versions, write_text
        from firstcontact.twin import CONDITIONS
        from firstcontact_lab.report.folder import REPORT, RESULTS, sole_use
        from firstcontact_lab.report.results import read_results, write_results
        from firstcontact_lab.study.benchmark import QUICK, Size, benchmark
        from firstcontact_lab.study.benchmark_page import BenchmarkResults, in_words, render
        from firstcontact_lab.study.recorded_benchmark import benchmark_recordings

        names = [self.condition] if self.condition else list(CONDITIONS)
        if (self.out / RESULTS).exists():
            read_results(self.out / RESULTS, BenchmarkResults)  # refuse to overwrite other results
        elif (self.out / REPORT).exists():
            raise InputError(
                f"{self.out / REPORT} was not made by a benchmark: choose another --out"
            )
        began = time.monotonic()
        with sole_use(self.out), parallel(worker_count(self.workers)) as runner:
            conditions, recorded = {}, None
            if self.recordings is not None:
                recorded = benchmark_recordings(
                    self.regressor, self.recordings, self.seed, runner, print
                )
            else:
                size = QUICK if self.quick else Size()
                conditions = dict(benchmark(self.regressor, names, size, self.seed, runner, print))
        command = shlex.join(["firstcontact", *sys.argv[1:]])
        results = BenchmarkResults(
            contender=self.regressor,
            command=command,
            quick=self.quick,
            seed=self.seed,
            seconds=round(time.monotonic() - began, 1),
            versions=installed_versions(),
            conditions=conditions,
            recordings=recorded,
        )
        write_results(self.out / RESULTS, results)
        write_text(self.out / REPORT, render(results))
        for line in in_words(results):
            print(line)
        print(self.out / REPORT)
