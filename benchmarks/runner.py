"""Time of the same work with one and with two workers, as local processes and as Dask workers.

All workers run, and have loaded the compiled functions, before the measurement begins. The work is
pinches of the twin, and cross-validated support vector regressions on them. Run it on an idle
machine: ``OMP_NUM_THREADS=1 python benchmarks/runner.py``.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from distributed import LocalCluster

from firstcontact.core import Dataset
from firstcontact.jobs import Runner, parallel, use_cluster
from firstcontact.models import Task
from firstcontact.models.labelled_data import DURATION, LabelledWindows, labelled_windows
from firstcontact.models.splits import by_session
from firstcontact.models.training import Question, held_out
from firstcontact.twin import simulate


@contextmanager
def local(workers: int) -> Iterator[None]:
    """Compute without a cluster within the ``with`` block.

    Regressions use ``workers`` processes, pinches use threads.
    """
    yield


@contextmanager
def cluster(workers: int) -> Iterator[None]:
    """Compute on a Dask cluster on this machine within the ``with`` block."""
    with (
        LocalCluster(
            n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None
        ) as dask,
        use_cluster(dask.scheduler_address),
    ):
        yield


def regressions(data: LabelledWindows, runner: Runner) -> float:
    """Return the time to cross-validate a regression on these windows, s."""
    question = Question("svm", Task.REGRESSION, data, by_session(data.sessions, data.y, 0, 10))
    begin = time.perf_counter()
    held_out(runner, [question], 0)
    return time.perf_counter() - begin


def pinches(each: int, workers: int) -> float:
    """Return the time to simulate ``each`` pinches of each block, s."""
    with tempfile.TemporaryDirectory() as folder:
        begin = time.perf_counter()
        simulate(
            Path(folder, "pinches"), pinches_per_block=each, pinches_per_object=0, workers=workers
        )
        return time.perf_counter() - begin


def windows(dataset: Dataset) -> LabelledWindows:
    """Return windows of the pinches, which start at the known contacts."""
    return labelled_windows(dataset, [p.first for p in dataset.pinches], DURATION, dataset.shore_a)


def main() -> dict[str, float]:
    """Measure both kinds of workers and print the table. Return the ratios by name."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--pinches", type=int, default=100, help="pinches of each block")
    settings = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        made = simulate(
            Path(folder, "twin"), pinches_per_block=settings.pinches, pinches_per_object=0
        )
        data = windows(made)
    ratios = {}
    for place, name in ((local, "this machine"), (cluster, "cluster")):
        spent = {}
        for workers in (1, 2):
            with place(workers):
                with parallel(workers) as runner:
                    regressions(data.take(np.arange(0, len(data), 5)), runner)
                    folds = min(regressions(data, runner) for _ in range(3))
                pinches(4, workers)
                spent[workers] = np.array(
                    [folds, min(pinches(settings.pinches, workers) for _ in range(3))]
                )
        for k, work in enumerate(("regressions", "pinches")):
            one, two = spent[1][k], spent[2][k]
            print(f"{name}, {work}: 1 worker {one:.2f} s, 2 workers {two:.2f} s: {one / two:.2f}")
            ratios[f"{name}, {work}, 2 workers against 1"] = one / two
    return ratios


if __name__ == "__main__":
    main()
