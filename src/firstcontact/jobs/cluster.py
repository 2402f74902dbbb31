"""Runner of jobs on a Dask cluster."""

from __future__ import annotations

import logging
import pickle
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from functools import partial
from typing import Any, TypeVar
from urllib.parse import urlsplit

import cloudpickle  # type: ignore[import-untyped]
import dask
from distributed import Client, Future, KilledWorker
from distributed.comm import CommClosedError

from firstcontact.core import ArgumentError, InputError
from firstcontact.jobs.runners import Runner, Tick, pack_payload, run_job, using

A = TypeVar("A")
B = TypeVar("B")

_log = logging.getLogger("firstcontact.jobs")

#: Time within which a scheduler or worker must answer, s.
PATIENCE = 10.0
#: Packages that results depend on. Workers must have the same versions as this process.
PACKAGES = ("firstcontact", "numpy", "scipy", "scikit-learn", "torch")
GONE = "the connection to the cluster is lost: start the cluster and this command again"


class ClusterRunner(Runner):
    """Runner that submits one task per job to a Dask cluster.

    It does not use joblib's Dask backend, which waits forever for tasks that were cancelled or
    whose worker was killed. Raises InputError if the connection is lost.
    """

    def __init__(self, client: Client, tick: Tick) -> None:
        self._client, self._tick = client, tick

    def stream(
        self, function: Callable[..., B], jobs: Sequence[A], *shared: object
    ) -> Generator[B, None, None]:
        if self._client.status != "running":
            raise InputError(GONE)
        submit = partial(self._client.submit, pure=False)
        # If the worker that holds the shared data ends, the scheduler repeats this task.
        payload = submit(_identity, pack_payload(shared)) if shared else None
        # Pickled here, because Dask's own messages give compiled code arrays that are not aligned.
        works = (cloudpickle.dumps((function, job)) for job in jobs)
        tasks = deque(submit(_run_pickled, work, payload) for work in works)
        try:
            for finished in range(1, len(tasks) + 1):
                result: B = _result(tasks[0])
                tasks.popleft()  # the worker forgets the result
                self._tick(finished, len(jobs))
                yield result
        finally:
            if self._client.status == "running":
                self._client.cancel(list(tasks))


def _identity(payload: Any) -> Any:
    return payload


def _run_pickled(work: bytes, payload: Any) -> bytes:
    function, job = pickle.loads(work)  # noqa: S301  # pickled by this program
    return pickle.dumps(run_job(function, job, payload))


def _result(task: Future[bytes]) -> Any:
    try:
        return pickle.loads(task.result())  # noqa: S301  # pickled by this program
    except KilledWorker as error:
        raise InputError(
            "several workers of the cluster ended while they ran the same job: give the workers "
            "more memory"
        ) from error
    except (CancelledError, CommClosedError) as error:
        raise InputError(GONE) from error


@contextmanager
def use_cluster(address: str) -> Iterator[None]:
    """Run jobs of :func:`firstcontact.jobs.parallel` on a Dask cluster in the ``with`` block.

    ``address`` is the scheduler's, as "tcp://HOST:PORT". Raises ArgumentError if no scheduler or
    worker answers there, or if a worker has other versions of packages.
    """
    # Errors below name the problem in one sentence; the library's log lines would repeat it.
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    settings = {
        "distributed.admin.large-graph-warning-threshold": "1 TiB",  # shared data are large
        "distributed.comm.timeouts.connect": f"{PATIENCE} s",
    }
    with dask.config.set(settings), _connected(address) as client:
        _check(client, address)
        _log.info("cluster %s: %s", address, client.nthreads())
        with using(partial(ClusterRunner, client)):
            yield


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    try:
        parts = urlsplit(address)
        if not (parts.scheme in ("tcp", "tls") and parts.hostname and parts.port):
            raise ValueError(address)
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ArgumentError(
            f"no Dask scheduler answers at --cluster {address}: "
            "start one with `dask scheduler`, and give its address as tcp://HOST:PORT"
        ) from error
    try:
        yield client
    finally:
        try:
            client.close()
        except RuntimeError:  # Dask fails halfway if the scheduler has just ended
            client.close()


def _check(client: Client, address: str) -> None:
    try:
        client.wait_for_workers(1, timeout=PATIENCE)
    except TimeoutError as error:
        raise ArgumentError(
            f"--cluster {address} has no workers: start some with `dask worker {address}`"
        ) from error
    found = client.get_versions(packages=PACKAGES)
    # The scheduler also deserialises the tasks that it passes on.
    places = {"scheduler": found["scheduler"]}
    places |= {f"worker {worker}": versions for worker, versions in found["workers"].items()}
    for package in ("python", *PACKAGES):
        local = _without_build_tag(found["client"]["packages"][package])
        for place, versions in places.items():
            remote = _without_build_tag(versions["packages"][package])
            if local not in (remote, "none"):
                raise ArgumentError(
                    f"the {place} of --cluster {address} has {package} {remote}, but this process "
                    f"has {local}: install the same version there"
                )


def _without_build_tag(number: str | None) -> str:
    return (number or "none").partition("+")[0]
