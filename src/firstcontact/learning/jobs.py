"""Trainings side by side: one thread each, none left behind."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol, TypeVar

from firstcontact.core.parent import follow

A = TypeVar("A")
B = TypeVar("B")

#: Workers take one core each, so no library inside them may start threads.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


class Runner(Protocol):
    """Does many alike."""

    def map(self, function: Callable[[A], B], jobs: Sequence[A]) -> list[B]:
        """Results in the order of the jobs."""
        ...


class Serial:
    """One after the other, here."""

    def map(self, function: Callable[[A], B], jobs: Sequence[A]) -> list[B]:
        """Results in the order of the jobs."""
        return [function(job) for job in jobs]


def _begin(parent: int) -> None:
    """What a worker does first."""
    # Signals of the terminal reach the whole process group; the parent alone decides, ...
    for name in ("SIGINT", "SIGHUP", "SIGQUIT"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # ... and where it is killed, its workers are, in the middle of whatever they do.
    follow(parent)


class Parallel:
    """Processes that are fresh (spawned), reused, and killed on the way out.

    To be made in a thread that lives as long as they do, such as the main one: workers end with
    the thread that started them.

    Parameters
    ----------
    workers
        Processes.
    tick
        Called here with (done, all) as jobs finish.
    """

    def __init__(
        self, workers: int, tick: Callable[[int, int], None] = lambda done, all_: None
    ) -> None:
        from joblib.externals.loky import get_reusable_executor

        self._tick = tick
        self._executor = get_reusable_executor(
            max_workers=workers,
            timeout=600,
            initializer=_begin,
            initargs=(os.getpid(),),
            env={**ONE_THREAD},
        )

    def map(self, function: Callable[[A], B], jobs: Sequence[A]) -> list[B]:
        """Results in the order of the jobs; the first error ends it."""
        from concurrent.futures import as_completed

        futures = [self._executor.submit(function, job) for job in jobs]
        try:
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                self._tick(done, len(futures))
        except Exception:
            # Whoever goes on after an error is not to wait for the rest.
            for future in futures:
                future.cancel()
            raise
        return [future.result() for future in futures]

    def close(self) -> None:
        """End the workers, at once."""
        self._executor.shutdown(wait=True, kill_workers=True)


@contextmanager
def parallel(
    workers: int, tick: Callable[[int, int], None] = lambda done, all_: None
) -> Iterator[Runner]:
    """A :class:`Parallel` that leaves no process behind, whatever happens inside."""
    runner = Parallel(workers, tick)
    try:
        yield runner
    finally:
        runner.close()


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
