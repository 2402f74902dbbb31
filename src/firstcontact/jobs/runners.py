"""Parallel jobs on this computer's cores, or on the backend of ``joblib.parallel_config``."""

from __future__ import annotations

import math
import os
import pickle
import signal
import sys
import threading
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any, Literal, TypeVar
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError
from firstcontact.jobs.children import follow

A = TypeVar("A")
B = TypeVar("B")
Tick = Callable[[int, int], object]

#: Environment variables that numerical libraries read when they are loaded. Libraries that are
#: loaded already need threadpoolctl instead.
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")

#: Idle time after which a worker ends, s. Workers end with their runner anyway, so any long time
#: below the system's longest timeout of 24 days will do.
IDLE = 7 * 86_400

#: Largest number of worker processes on one machine.
MOST_WORKERS = 512

#: Alignment of the longest numbers, bytes.
WORD = 16
#: Alignment of packed arrays, bytes.
ALIGNMENT = 64

_job_lock = threading.RLock()
_opened: tuple[bytes, tuple[Any, ...]] = (b"", ())
#: Functions that make the runner of a cluster, see :func:`using`.
_runners: list[Callable[[Tick], Runner]] = []


class Runner(ABC):
    """Base class of runners, which call ``function(job, *shared)`` for each of many small jobs.

    The shared data are sent to the workers once. Arrays in them are read-only.
    """

    @abstractmethod
    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        """Yield the results in the order of the jobs. The first error ends the stream."""

    def map(self, function: Callable[..., B], jobs: Sequence[A], *shared: object) -> list[B]:
        """Return all results in the order of the jobs. The first error ends the run."""
        return list(self.stream(function, jobs, *shared))


class Serial(Runner):
    """Runner that calls one job after the other in this process, on one thread."""

    def __init__(self, tick: Tick = lambda finished, total: None) -> None:
        self._tick = tick

    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        for finished, job in enumerate(jobs, start=1):
            with one_thread():
                result = function(job, *shared)
            self._tick(finished, len(jobs))
            yield result


class Pool(Runner):
    """Runner that calls jobs in parallel with :class:`joblib.Parallel`."""

    def __init__(self, parallel: Any, tick: Tick, share_memory: bool) -> None:
        self._parallel, self._tick, self._share_memory = parallel, tick, share_memory

    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        if self._share_memory:
            calls: list[Any] = [(function, (job, *shared), {}) for job in jobs]
        else:
            payload = pack_payload(shared) if shared else None
            calls = [(run_job, (function, job, payload), {}) for job in jobs]
        results = self._parallel(calls)
        try:
            finished = 0
            for result in results:
                finished += 1
                self._tick(finished, len(jobs))
                yield result
            if finished != len(jobs):
                raise RuntimeError(f"joblib returned {finished} results of {len(jobs)} jobs")
        finally:
            with warnings.catch_warnings():  # joblib warns about results that were not used
                warnings.simplefilter("ignore")
                results.close()


@contextmanager
def parallel(
    workers: int,
    tick: Tick = lambda finished, total: None,
    prefer: Literal["processes", "threads"] = "processes",
) -> Iterator[Runner]:
    """Yield a runner for ``workers`` parallel jobs. No process remains after the ``with`` block.

    ``tick`` is called with the numbers of finished jobs and of all jobs. ``prefer`` says if workers
    are processes or threads. In a :func:`using` block, the runner is that of the block.
    """
    if _runners:
        yield _runners[-1](tick)
        return
    import joblib
    from joblib.parallel import get_active_backend

    backend = get_active_backend(prefer=prefer)[0]
    processes = backend.supports_inner_max_num_threads  # only local processes take this setting
    share_memory = getattr(backend, "supports_sharedmem", False) and prefer == "threads"
    if workers == 1 and (processes or share_memory):
        yield Serial(tick)
        return
    # Loky can fail when it ends with more jobs in its queue than it has handed out.
    ahead = "2 * n_jobs" if processes else "all"
    with _process_backend() if processes else joblib.parallel_config() as config:
        pool = joblib.Parallel(
            workers, prefer=prefer, return_as="generator", pre_dispatch=ahead, batch_size=1
        )
    with pool:
        try:
            yield Pool(pool, tick, share_memory)
        finally:
            if processes:
                config["backend"].abort_everything(ensure_ready=False)


@contextmanager
def using(runner: Callable[[Tick], Runner]) -> Iterator[None]:
    """Make :func:`parallel` yield ``runner(tick)`` in the ``with`` block, such as a cluster's."""
    _runners.append(runner)
    try:
        yield
    finally:
        _runners.pop()


def _process_backend() -> Any:
    """Return the context manager in which joblib runs jobs in processes on this computer."""
    import joblib

    return joblib.parallel_config(
        "loky",
        inner_max_num_threads=1,
        idle_worker_timeout=IDLE,
        initializer=_init_worker,
        initargs=(os.getpid(),),
    )


def _init_worker(parent: int) -> None:
    from joblib.externals.loky import process_executor

    # If a worker grows by 300 MB after its first job, Loky assumes a memory leak and replaces it.
    # Here the growth is shared data, or a library that a later job loads.
    process_executor._MAX_MEMORY_LEAK_SIZE = math.inf
    # The terminal's signals reach the whole process group. Only the parent handles them ...
    for name in ("SIGINT", "SIGHUP", "SIGQUIT"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    # ... and if the parent is killed, its workers are killed too.
    follow(parent)


def run_job(function: Callable[..., B], job: object, payload: Any) -> B:
    with _job_lock, one_thread():
        return function(job, *(() if payload is None else unpack_payload(payload)))


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit numerical libraries to one thread in the ``with`` block, as parallel jobs need it."""
    import joblib

    previous = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        libraries = _numerical_libraries(len(sys.modules))
        with libraries.limit(limits=1), joblib.parallel_config("sequential", n_jobs=1):
            yield
    finally:
        for name, value in previous.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@lru_cache(maxsize=1)
def _numerical_libraries(modules: int) -> Any:
    """Return threadpoolctl's controller, which sets the threads of the loaded numerical libraries.

    ``modules`` is the number of imported modules. The search for libraries takes 2 ms, so it is
    repeated only if this number changes.
    """
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()


def worker_count(workers: int) -> int:
    """Return the number of worker processes: ``workers``, or for 0 the number of cores.

    Raises ArgumentError if the number is out of range.
    """
    if not 0 <= workers <= MOST_WORKERS:
        raise ArgumentError(
            f"{workers} is out of range: give 0 (all cores) to {MOST_WORKERS}", parameter="workers"
        )
    return workers or cores()


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def pack_payload(values: tuple[Any, ...]) -> NDArray[np.uint8]:
    """Pack values into one array of bytes, from which workers share the values' arrays.

    :func:`unpack_payload` is the inverse.
    """
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(values, protocol=5, buffer_callback=buffers.append)
    parts: list[Any] = [head, *(buffer.raw() for buffer in buffers)]
    sizes = np.array([len(part) for part in parts], dtype=np.int64)
    begin = uuid4().bytes + len(sizes).to_bytes(8, "little") + sizes.tobytes()
    places = _places(len(begin), sizes)
    out = np.zeros(places[-1] + sizes[-1], dtype=np.uint8)
    out[: len(begin)] = np.frombuffer(begin, dtype=np.uint8)
    for place, part in zip(places, parts, strict=True):
        out[place : place + len(part)] = np.frombuffer(part, dtype=np.uint8)
    return out


def unpack_payload(array: NDArray[np.uint8]) -> tuple[Any, ...]:
    """Return the values that :func:`pack_payload` packed, with read-only arrays.

    The values of the last call are cached.
    """
    global _opened
    key = array[:16].tobytes()
    if _opened[0] != key:
        if array.ctypes.data % WORD:  # in a message of Dask; compiled code needs whole words
            array = array.copy()
        count = int.from_bytes(array[16:24].tobytes(), "little")
        sizes = np.frombuffer(array[24 : 24 + 8 * count].tobytes(), dtype=np.int64)
        view = array.data.toreadonly()
        head, *buffers = (
            view[place : place + size]
            for place, size in zip(_places(24 + 8 * count, sizes), sizes, strict=True)
        )
        _opened = key, pickle.loads(head, buffers=buffers)  # noqa: S301  # packed by this program
    return _opened[1]


def _places(begin: int, sizes: NDArray[np.int64]) -> list[int]:
    places = []
    for size in sizes:
        begin = -(-begin // ALIGNMENT) * ALIGNMENT
        places.append(begin)
        begin += int(size)
    return places
