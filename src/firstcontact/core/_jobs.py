"""Many alike jobs: on the cores of this machine, or wherever ``joblib.parallel_config`` says."""

from __future__ import annotations

import math
import os
import signal
import threading
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Literal, TypeVar

from firstcontact.core._die_with_parent import follow
from firstcontact.core._errors import InputError
from firstcontact.core._foreign import ForeignCode
from firstcontact.core._shared_payload import pack_payload, unpack_payload

A = TypeVar("A")
B = TypeVar("B")
Tick = Callable[[int, int], object]

#: Heeded by libraries when they are loaded; those that are there already can be told.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: Workers wait so long for the next job, s: they end with the runner, however long it works on
#: something else meanwhile. Less than the 24 days that a timeout of the system can hold.
IDLE = 7 * 86_400

#: More processes than this no machine is meant to run.
MOST_WORKERS = 512

_alone = threading.Lock()


class Runner(ABC):
    """Does many alike jobs.

    ``function(job, *shared)`` is called for every job. Jobs are small; what all of them need is
    shared: it is sent once, and its arrays are read-only.
    """

    @abstractmethod
    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        """Results one by one, in the order of the jobs; the first error ends it."""

    def map(self, function: Callable[..., B], jobs: Sequence[A], *shared: object) -> list[B]:
        """All results in the order of the jobs; the first error ends it."""
        return list(self.stream(function, jobs, *shared))


class Serial(Runner):
    """One after the other, here, on one thread.

    Parameters
    ----------
    tick
        Called with (done, all) after each job.
    """

    def __init__(self, tick: Tick = lambda done, total: None) -> None:
        self._tick = tick

    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        """Results one by one, in the order of the jobs; the first error ends it."""
        for done, job in enumerate(jobs, start=1):
            with one_thread():
                result = function(job, *shared)
            self._tick(done, len(jobs))
            yield result


class Pool(Runner):
    """Jobs through :class:`joblib.Parallel`.

    Parameters
    ----------
    parallel
        Open, and returns a generator.
    tick
        Called here with (done, all) as results come.
    together
        Jobs share this process's memory, and do not disturb one another in it.
    """

    def __init__(self, parallel: Any, tick: Tick, together: bool) -> None:
        self._parallel, self._tick, self._together = parallel, tick, together

    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        """Results one by one, in the order of the jobs; the first error ends it."""
        if self._together:
            calls: list[Any] = [(function, (job, *shared), {}) for job in jobs]
        else:
            whole = pack_payload(shared) if shared else None
            calls = [(_apart, (function, job, whole), {}) for job in jobs]
        results = self._parallel(calls)
        try:
            for done, result in enumerate(results, start=1):
                self._tick(done, len(jobs))
                yield result
        finally:
            with warnings.catch_warnings():  # that not all results were wanted
                warnings.simplefilter("ignore")
                results.close()


@contextmanager
def parallel(
    workers: int,
    tick: Tick = lambda done, total: None,
    prefer: Literal["processes", "threads"] = "processes",
) -> Iterator[Runner]:
    """A runner that leaves no process behind, whatever happens inside.

    Inside a ``joblib.parallel_config`` that names a backend, jobs go there. Otherwise they go to
    processes of this machine that are fresh (spawned), have one thread each, are reused, and are
    killed on the way out, or as soon as this process is gone.

    To be used in a thread that lives as long as they do, such as the main one: workers end with
    the thread that started them.

    Parameters
    ----------
    workers
        On this machine; 1 means here, one job after the other.
    tick
        Called here with (done, all) as results come.
    prefer
        "threads" on this machine for jobs that let go of Python's lock.
    """
    import joblib
    from joblib.parallel import get_active_backend

    backend = get_active_backend(prefer=prefer)[0]
    processes = backend.supports_inner_max_num_threads  # only those of this machine can be told
    together = getattr(backend, "supports_sharedmem", False) and prefer == "threads"
    if workers == 1 and (processes or together):
        yield Serial(tick)
        return
    # Loky may stumble over its queue where it is ended with more jobs in it than it handed out.
    ahead = "2 * n_jobs" if processes else "all"
    with _processes() if processes else joblib.parallel_config() as config:
        pool = joblib.Parallel(
            workers, prefer=prefer, return_as="generator", pre_dispatch=ahead, batch_size=1
        )
    with pool:
        try:
            yield Pool(pool, tick, together)
        finally:
            if processes:
                config["backend"].abort_everything(ensure_ready=False)


def _processes() -> Any:
    """What processes of this machine are to be like."""
    import joblib

    return joblib.parallel_config(
        "loky",
        inner_max_num_threads=1,
        idle_worker_timeout=IDLE,
        initializer=_begin,
        initargs=(os.getpid(),),
    )


def _begin(parent: int) -> None:
    """What a worker does first."""
    from joblib.externals.loky import process_executor

    # Loky takes 300 MB more than after the first job for a leak, and replaces the worker in the
    # middle of its jobs. Here that is a library that a later job loads, or what jobs share.
    process_executor._MAX_MEMORY_LEAK_SIZE = math.inf
    # Signals of the terminal reach the whole process group; the parent alone decides, ...
    for name in ("SIGINT", "SIGHUP", "SIGQUIT"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # ... and where it is killed, its workers are, in the middle of whatever they do.
    follow(parent)


def _apart(function: Callable[..., B], job: object, whole: Any) -> B:
    """A job in another process, which may have threads for more: what is random is the process's.

    Workers of a cluster are not started by us, so threads are limited here.
    """
    with _alone, one_thread(), ForeignCode():
        return function(job, *(() if whole is None else unpack_payload(whole)))


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep libraries from spreading: beside other work they gain nothing, and lose much."""
    import joblib
    import threadpoolctl

    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        with threadpoolctl.threadpool_limits(1), joblib.parallel_config("sequential", n_jobs=1):
            yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def worker_count(workers: int) -> int:
    """Processes for what ``--workers`` says: 0 means all cores.

    Raises
    ------
    InputError
        Fewer than none, or more than any machine has.
    """
    if not 0 <= workers <= MOST_WORKERS:
        raise InputError(f"--workers is {workers}: give 0 for all cores, or up to {MOST_WORKERS}")
    return workers or cores()


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
