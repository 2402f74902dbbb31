"""Joblib backend that runs jobs on a Dask cluster."""

from __future__ import annotations

import logging
import platform
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import Any
from urllib.parse import urlsplit

import cloudpickle  # type: ignore[import-untyped]
import dask
import numpy as np
from distributed import Client, Future, KilledWorker
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError
from joblib import parallel_config
from joblib.parallel import ParallelBackendBase

from firstcontact.core._errors import InputError

_log = logging.getLogger(__name__)

#: Time within which a scheduler or worker must answer, s.
PATIENCE = 10.0
#: Packages that results depend on. Workers must have the same versions as this process.
PACKAGES = ("firstcontact", "numpy", "scipy", "scikit-learn", "torch")
#: Arrays of this many bytes and more are sent separately, and only once.
LARGE = 100_000
GONE = "the connection to the cluster is lost: start the cluster and this command again"


class ClusterBackend(ParallelBackendBase):  # type: ignore[misc]  # joblib states no types
    """Joblib backend that submits calls as tasks of a Dask cluster."""

    supports_retrieve_callback = True

    def __init__(self, client: Client) -> None:
        super().__init__(nesting_level=0)
        self._client = client
        self._shared: dict[int, tuple[Any, Future[Any]]] = {}
        self._tasks: set[Future[Any]] = set()
        self._delivered = threading.Condition()

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Return the number of the cluster's cores, or 2 for one core."""
        try:
            return max(2, int(sum(self._client.ncores().values())))
        except OSError as error:
            raise InputError(GONE) from error

    def submit(self, func: Any, callback: Callable[[Future[Any]], object]) -> Future[Any]:
        """Submit a batch of calls."""
        calls = [
            (
                call,
                [self._reference(a) for a in arguments],
                {k: self._reference(a) for k, a in more.items()},
            )
            for call, arguments, more in func.items
        ]
        task = self._client.submit(_run_batch, version("firstcontact"), calls, pure=False)
        with self._delivered:
            self._tasks.add(task)
        task.add_done_callback(partial(self._deliver, callback))
        return task

    def _deliver(self, callback: Callable[[Future[Any]], object], task: Future[Any]) -> None:
        try:
            callback(task)
        finally:
            with self._delivered:
                self._tasks.discard(task)
                self._delivered.notify_all()

    def _reference(self, array: Any) -> Any:
        if not isinstance(array, np.ndarray) or array.nbytes < LARGE:
            return array
        if id(array) not in self._shared:
            self._shared[id(array)] = array, self._client.submit(_identity, array, pure=False)
        return self._shared[id(array)][1]

    def retrieve_result_callback(self, task: Future[Any]) -> Any:
        """Return the result of a task."""
        try:
            return task.result()
        except KilledWorker as error:
            raise InputError(
                "several workers of the cluster ended while they ran the same job: give the "
                "workers more memory"
            ) from error
        except (FutureCancelledError, CommClosedError) as error:
            raise InputError(GONE) from error

    def stop_call(self) -> None:
        """Forget the large arrays that the jobs of the last call shared."""
        self._shared.clear()

    def abort_everything(self, ensure_ready: bool = True) -> None:
        """Cancel all tasks that have not started, and wait until joblib knows of it."""
        with self._delivered:
            tasks = set(self._tasks)
        if self._client.status == "running":
            self._client.cancel(list(tasks))
            with self._delivered:
                self._delivered.wait_for(lambda: tasks.isdisjoint(self._tasks), PATIENCE)
        self._shared.clear()


def _identity(array: Any) -> Any:
    return array


def _run_batch(expected: str, calls: list[tuple[Callable[..., Any], list[Any], Any]]) -> list[Any]:
    """Run a batch of calls in a worker. Return their results, as joblib expects them."""
    if expected != version("firstcontact"):
        raise InputError(
            f"a worker of the cluster has firstcontact {version('firstcontact')}, not {expected}: "
            "install the same version there"
        )
    return [
        call(*map(_aligned, arguments), **{k: _aligned(a) for k, a in more.items()})
        for call, arguments, more in calls
    ]


def _aligned(argument: Any) -> Any:
    """Return a copy of an argument, with all arrays in it aligned; an aligned array as it is."""
    if isinstance(argument, np.ndarray):
        return np.require(argument, requirements="A")
    # Up to this protocol NumPy copies arrays, and does not refer to the message.
    return cloudpickle.loads(cloudpickle.dumps(argument, protocol=4))


@contextmanager
def use_cluster(address: str) -> Iterator[None]:
    """Run the jobs of :func:`firstcontact.core._jobs.parallel` on a Dask cluster.

    Parameters
    ----------
    address
        Address of the scheduler, as tcp://HOST:PORT.

    Raises
    ------
    InputError
        No scheduler answers, it has no workers, or versions of packages differ.
    """
    # Errors below name the problem in one sentence; the library's log lines would repeat it.
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    settings = {
        "distributed.admin.large-graph-warning-threshold": "1 TiB",  # shared data are large
        "distributed.comm.timeouts.connect": f"{PATIENCE} s",
    }
    try:
        with dask.config.set(settings), _connected(address) as client:
            _check(client, address)
            _log.info("cluster %s: %s", address, client.nthreads())
            with parallel_config(ClusterBackend(client)):
                yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    client = _client(address)
    try:
        yield client
    finally:
        try:
            client.close()
        except RuntimeError:  # Dask fails halfway if the scheduler has just ended
            client.close()


def _client(address: str) -> Client:
    try:
        parts = urlsplit(address)
        if parts.scheme in ("tcp", "tls") and parts.hostname and parts.port:
            return Client(address, timeout=PATIENCE, set_as_default=False)
        error: Exception | None = None
    except (OSError, ValueError) as cause:
        error = cause
    raise InputError(
        f"--cluster {address}: no Dask scheduler answers there: "
        "start one with `dask scheduler` and give its address as tcp://HOST:PORT"
    ) from error


def _check(client: Client, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise InputError(
            f"--cluster {address} has no workers: start some with `dask worker {address}`"
        ) from error
    queries: dict[str, Callable[[], str]] = {"Python": platform.python_version}
    queries |= {package: partial(version, package) for package in PACKAGES}
    for package, query in queries.items():
        with suppress(PackageNotFoundError):  # not installed here, so not needed there
            local = _public(query())
            for place, remote in _remote_versions(client, query).items():
                if remote != local:
                    raise InputError(
                        f"--cluster {address}: its {place} has {package} {remote}, not {local}: "
                        "install the same version there"
                    )


def _remote_versions(client: Client, query: Callable[[], str]) -> dict[str, str]:
    """Return a package's version in the scheduler and in each worker; "none" if it is missing."""
    try:
        # The scheduler also deserialises the tasks that it passes on.
        scheduler = _public(client.run_on_scheduler(query))
    except PackageNotFoundError:
        scheduler = "none"
    versions = {"scheduler": scheduler}
    for worker, result in client.run(query, on_error="return").items():
        missing = isinstance(result, Exception)
        versions[f"worker {worker}"] = "none" if missing else _public(result)
    return versions


def _public(number: str) -> str:
    """Return a version number without its build tag (the text after ``+``)."""
    return number.partition("+")[0]
