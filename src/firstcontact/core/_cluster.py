"""Work on a Dask cluster: joblib's calls become tasks of its scheduler."""

from __future__ import annotations

import logging
import platform
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from typing import Any
from urllib.parse import urlsplit

import dask
import numpy as np
from distributed import Client, Future, KilledWorker
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError
from joblib import parallel_config
from joblib.parallel import ParallelBackendBase

from firstcontact.core._errors import InputError

_log = logging.getLogger(__name__)

#: Whoever is there answers sooner, s.
PATIENCE = 10.0
#: What results depend on: workers have the versions that are here.
PACKAGES = ("firstcontact", "numpy", "scipy", "scikit-learn", "numba", "torch")
#: Arrays from so many bytes on travel by themselves, and once.
LARGE = 100_000
GONE = "the cluster has gone away: start it, and this, again"


class ClusterBackend(ParallelBackendBase):  # type: ignore[misc]  # joblib states no types
    """Joblib's calls as tasks of a cluster.

    Joblib's own backend for Dask waits for ever for a task that has killed its workers, or whose
    scheduler is gone; does the work here where the cluster has a single worker; and loses what
    jobs share with the worker that holds it.

    Parameters
    ----------
    client
        Connected.
    """

    supports_retrieve_callback = True

    def __init__(self, client: Client) -> None:
        super().__init__(nesting_level=0)
        self._client = client
        self._shared: dict[int, tuple[Any, Future[Any]]] = {}
        self._tasks: set[Future[Any]] = set()

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Cores of the cluster; of a single one as two, as joblib would not ask us for less."""
        try:
            return max(2, int(sum(self._client.ncores().values())))
        except OSError as error:
            raise InputError(GONE) from error

    def submit(self, func: Any, callback: Callable[[Future[Any]], object]) -> Future[Any]:
        """A batch of calls, whose large arrays are tasks, too: a lost worker's are made again."""
        calls = [
            (
                call,
                [self._reference(a) for a in arguments],
                {k: self._reference(a) for k, a in more.items()},
            )
            for call, arguments, more in func.items
        ]
        task = self._client.submit(_done, version("firstcontact"), calls, pure=False)
        self._tasks.add(task)
        task.add_done_callback(callback)
        return task

    def _reference(self, array: Any) -> Any:
        if not isinstance(array, np.ndarray) or array.nbytes < LARGE:
            return array
        if id(array) not in self._shared:
            self._shared[id(array)] = array, self._client.submit(_itself, array, pure=False)
        return self._shared[id(array)][1]

    def retrieve_result_callback(self, task: Future[Any]) -> Any:
        """The result.

        Raises
        ------
        InputError
            The cluster has lost it.
        """
        self._tasks.discard(task)
        try:
            return task.result()
        except KilledWorker as error:
            raise InputError(
                "several workers of the cluster ended over the same job: give them more memory"
            ) from error
        except (FutureCancelledError, CommClosedError) as error:
            raise InputError(GONE) from error

    def stop_call(self) -> None:
        """Forget what was shared."""
        self._shared.clear()

    def abort_everything(self, ensure_ready: bool = True) -> None:
        """Whatever has not begun does not begin."""
        if self._client.status == "running":
            self._client.cancel(list(self._tasks))
        self._tasks.clear()
        self._shared.clear()


def _itself(array: Any) -> Any:
    return array


def _done(wanted: str, calls: list[tuple[Callable[..., Any], list[Any], Any]]) -> list[Any]:
    """The results of a batch of calls, as joblib takes them."""
    if wanted != version("firstcontact"):
        raise InputError(
            f"a worker of the cluster has firstcontact {version('firstcontact')}, not {wanted}: "
            "install the same there"
        )
    return [call(*arguments, **more) for call, arguments, more in calls]


@contextmanager
def use_cluster(address: str) -> Iterator[None]:
    """Work of :func:`firstcontact.core._jobs.parallel` is done on a cluster.

    Parameters
    ----------
    address
        Of its scheduler, as tcp://HOST:PORT.

    Raises
    ------
    InputError
        Nobody answers there, it has no workers, or they have other versions.
    """
    # What users are to know is said in one sentence.
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    settings = {
        "distributed.admin.large-graph-warning-threshold": "1 TiB",  # shared data are to travel
        "distributed.comm.timeouts.connect": f"{PATIENCE} s",
    }
    try:
        with dask.config.set(settings), _client(address) as client:
            _check(client, address)
            _log.info("cluster %s: %s", address, client.nthreads())
            with parallel_config(ClusterBackend(client)):
                yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def _client(address: str) -> Client:
    try:
        parts = urlsplit(address)
        if parts.scheme in ("tcp", "tls") and parts.hostname and parts.port:
            return Client(address, timeout=PATIENCE, set_as_default=False)
        error: Exception | None = None
    except (OSError, ValueError) as refused:
        error = refused
    raise InputError(
        f"--cluster {address}: no scheduler of Dask answers there; "
        "start one with `dask scheduler`, and name it as tcp://HOST:PORT"
    ) from error


def _check(client: Client, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise InputError(
            f"--cluster {address}: it has no workers; start some with `dask worker {address}`"
        ) from error
    asked: dict[str, Callable[[], str]] = {"Python": platform.python_version}
    asked |= {package: partial(version, package) for package in PACKAGES}
    for package, ask in asked.items():
        with suppress(PackageNotFoundError):  # what is not here is not needed there
            here = _public(ask())
            for place, there in _answers(client, ask).items():
                if there != here:
                    raise InputError(
                        f"--cluster {address}: its {place} has {package} {there}, not {here}: "
                        "install the same there"
                    )


def _answers(client: Client, ask: Callable[[], str]) -> dict[str, str]:
    """What scheduler and workers say; "none" where the package is missing."""
    try:
        # It reads the tasks that it passes on.
        scheduler = _public(client.run_on_scheduler(ask))
    except PackageNotFoundError:
        scheduler = "none"
    answers = {"scheduler": scheduler}
    for worker, answer in client.run(ask, on_error="return").items():
        missing = isinstance(answer, Exception)
        answers[f"worker {worker}"] = "none" if missing else _public(answer)
    return answers


def _public(number: str) -> str:
    """A version without what says how it was built."""
    return number.partition("+")[0]
