"""Trainings side by side: one thread each, none left behind."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Protocol, TypeVar

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


def _ignore_interrupts() -> None:
    # Ctrl-C reaches the whole process group; the parent alone decides.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


class Parallel:
    """Processes that are fresh (spawned), reused, and killed on the way out.

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
            initializer=_ignore_interrupts,
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


@contextmanager
def terminations_interrupt() -> Iterator[None]:
    """Treat SIGTERM as Ctrl-C, so that files and processes end well in both."""

    def interrupt(number: int, frame: Any) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
