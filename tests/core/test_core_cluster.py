"""A Dask cluster: jobs go there, survive a worker, and what cannot work is one sentence."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import joblib
import numpy as np
import pytest
from distributed import Client
from numpy.typing import NDArray

from dask_cluster import Cluster, cluster
from firstcontact.core import InputError, Serial, parallel, use_cluster
from firstcontact.core import _cluster as module
from processes import gone


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    with cluster(tmp_path_factory.mktemp("cluster"), 2) as found:
        yield found


def test_jobs_and_what_they_share_go_to_the_workers(two: Cluster) -> None:
    shared = np.arange(300_000, dtype=np.float32)
    ticks: list[tuple[int, int]] = []
    with (
        use_cluster(two.address),
        parallel(1, lambda done, total: ticks.append((done, total))) as runner,
    ):
        assert runner.map(picked, range(4), shared) == Serial().map(picked, range(4), shared)
        pids = set(runner.map(pid, range(8)))
        assert pids <= {worker.pid for worker in two.workers}
    assert ticks[:4] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    with parallel(1) as runner:
        assert runner.map(pid, [0]) == [os.getpid()]


def test_the_backend_that_joblib_brings_moves_them_too(two: Cluster) -> None:
    with (
        Client(two.address) as client,
        joblib.parallel_config("dask", client=client),
        parallel(1) as runner,
    ):
        assert os.getpid() not in runner.map(pid, range(4))


def test_what_others_do_with_joblib_goes_there_too_but_not_from_within_a_job(two: Cluster) -> None:
    large = np.ones(100_000)
    with use_cluster(two.address):
        calls = [joblib.delayed(added)(large, other=large, pause=0)] * 3
        there = joblib.Parallel(batch_size=2)(calls)
        (here,) = Serial().map(nested, [0])
        with parallel(1) as runner:
            inside = runner.map(nested, range(3))
    workers = {worker.pid for worker in two.workers}
    assert {total for total, _ in there} == {200_000.0}
    assert {number for _, number in there} <= workers
    assert here == {os.getpid()}
    assert all(len(pids) == 1 and pids <= workers for pids in inside)


def added(one: NDArray[np.float64], *, other: NDArray[np.float64], pause: int) -> tuple[float, int]:
    return float((one + other).sum()) + pause, os.getpid()


def nested(_: int) -> set[int]:
    return set(joblib.Parallel(n_jobs=2)(joblib.delayed(pid)(n) for n in range(4)))


def test_the_first_error_ends_the_map_and_the_next_one_works(two: Cluster) -> None:
    with use_cluster(two.address), parallel(1) as runner:
        with pytest.raises(InputError, match="job 1"):
            runner.map(refused, range(3))
        assert runner.map(abs, [-1]) == [1]


def test_a_single_worker_does_the_work_and_not_the_one_who_asks(tmp_path: Path) -> None:
    with cluster(tmp_path, 1) as one, use_cluster(one.address), parallel(1) as runner:
        assert set(runner.map(pid, range(3))) == {one.workers[0].pid}


def test_a_scheduler_that_ends_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "PATIENCE", 2.0)
    with cluster(tmp_path, 1) as lost, use_cluster(lost.address), parallel(1) as runner:
        stream = runner.stream(paused, [False, True, True])
        assert next(stream) is False
        lost.scheduler.kill()
        with pytest.raises(InputError):
            next(stream)
        with pytest.raises(InputError):
            runner.map(pid, [0])


def test_a_job_that_ends_its_workers_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    with cluster(tmp_path, 2) as doomed, use_cluster(doomed.address), parallel(1) as runner:
        with pytest.raises(InputError):
            runner.map(ended, range(2))
        assert any(gone(worker.pid) for worker in doomed.workers)


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1", "ftp://a:1", "tcp://a:port"])
def test_what_is_no_address_is_refused(address: str) -> None:
    with pytest.raises(InputError, match="tcp://HOST:PORT"), use_cluster(address):
        pass


def test_where_nobody_answers_and_where_nobody_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "PATIENCE", 0.3)
    with pytest.raises(InputError, match=r"127\.0\.0\.1"), use_cluster("tcp://127.0.0.1:1"):
        pass
    monkeypatch.setattr(module, "PATIENCE", 2.0)
    with (
        cluster(tmp_path, 0) as empty,
        pytest.raises(InputError, match="--cluster"),
        use_cluster(empty.address),
    ):
        pass


def test_workers_of_another_version_are_refused(tmp_path: Path) -> None:
    other = tmp_path / "packages" / "firstcontact-9.9.dist-info"
    other.mkdir(parents=True)
    (other / "METADATA").write_text("Metadata-Version: 2.1\nName: firstcontact\nVersion: 9.9\n")
    (tmp_path / "cluster").mkdir()
    with (
        cluster(tmp_path / "cluster", 1, first_on_path=other.parent) as strange,
        pytest.raises(InputError, match=r"has firstcontact 9\.9, not"),
        use_cluster(strange.address),
    ):
        pass


def pid(_: int) -> int:
    return os.getpid()


def picked(place: int, shared: NDArray[np.float32]) -> float:
    return float(shared[place])


def refused(job: int) -> int:
    if job == 1:
        raise InputError(f"job {job}")
    return job


def paused(still: bool) -> bool:
    if still:
        signal.pause()
    return still


def ended(_: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)
