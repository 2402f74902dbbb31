"""Jobs on a Dask cluster: they run there, survive lost workers, and fail with one sentence."""

import os
import signal
import threading

import numpy as np
import pytest

from dask_cluster import cluster
from firstcontact.core import InputError
from firstcontact.jobs import Serial, parallel
from processes import until


def use_cluster(address):
    # Only the process that runs these tests imports Dask.
    from firstcontact.jobs import use_cluster

    return use_cluster(address)


@pytest.fixture(scope="module")
def two_workers(tmp_path_factory):
    with cluster(tmp_path_factory.mktemp("cluster"), 2) as workers:
        yield workers


def test_jobs_and_shared_values_reach_the_workers(two_workers):
    shared = np.arange(300_000, dtype=np.float32)
    ticks: list[tuple[int, int]] = []
    with (
        use_cluster(two_workers.address),
        parallel(1, lambda finished, total: ticks.append((finished, total))) as runner,
    ):
        assert runner.map(picked, range(4), shared) == Serial().map(picked, range(4), shared)
        pids = set(runner.map(pid, range(8)))
        assert pids <= {worker.pid for worker in two_workers.workers}
    assert ticks[:4] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    with parallel(1) as runner:
        assert runner.map(pid, [0]) == [os.getpid()]


def test_arrays_in_arguments_are_aligned_on_the_workers(two_workers):
    """Compiled code refuses others. Dask's messages begin each array after text of any length."""
    jobs = [("x" * n, {"numbers": np.arange(500.0)}) for n in range(12)]
    with use_cluster(two_workers.address), parallel(2) as runner:
        assert all(runner.map(is_aligned, jobs))


def test_results_are_complete_after_a_cancelled_call(two_workers):
    """Cancelled tasks must not end a later call, nor take places in its results."""
    with use_cluster(two_workers.address), parallel(1) as runner:
        for _ in range(5):
            stream = runner.stream(squared_later, range(50))
            assert [next(stream), next(stream)] == [0, 1]
            stream.close()
            assert runner.map(squared_later, range(20)) == [n * n for n in range(20)]


def test_killed_worker_and_killed_scheduler_are_input_errors(tmp_path, monkeypatch):
    monkeypatch.setenv("DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES", "0")
    monkeypatch.setattr("firstcontact.jobs.cluster.PATIENCE", 4.0)
    with cluster(tmp_path, 2) as doomed, use_cluster(doomed.address), parallel(1) as runner:
        with pytest.raises(InputError, match="workers"):
            runner.map(ended, [0])
        until(lambda: any(worker.poll() is not None for worker in doomed.workers))
        stream = runner.stream(paused, [False, True, True])
        assert next(stream) is False
        doomed.scheduler.kill()
        with pytest.raises(InputError, match="connection"):
            next(stream)
        with pytest.raises(InputError, match="connection"):
            runner.map(pid, [0])


@pytest.mark.parametrize("address", ["nonsense", "tcp://127.0.0.1", "ftp://a:1", "tcp://a:port"])
def test_invalid_addresses_are_refused(address):
    with pytest.raises(InputError, match="tcp://HOST:PORT"), use_cluster(address):
        pass


def test_missing_scheduler_and_empty_cluster_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("firstcontact.jobs.cluster.PATIENCE", 2.0)
    with pytest.raises(InputError, match=r"127\.0\.0\.1"), use_cluster("tcp://127.0.0.1:1"):
        pass
    with (
        cluster(tmp_path, 0) as empty,
        pytest.raises(InputError, match="--cluster"),
        use_cluster(empty.address),
    ):
        pass


def test_workers_of_another_version_are_refused(tmp_path):
    metadata = tmp_path / "packages" / "firstcontact-9.9.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: firstcontact\nVersion: 9.9\n")
    (tmp_path / "cluster").mkdir()
    with (
        cluster(tmp_path / "cluster", 1, first_on_path=metadata.parent) as other_version,
        pytest.raises(InputError, match=r"\b9\.9\b"),
        use_cluster(other_version.address),
    ):
        pass


def is_aligned(job):
    return bool(job[1]["numbers"].flags.aligned)


def pid(_):
    return os.getpid()


def picked(place, shared):
    return float(shared[place])


def paused(should_pause):
    if should_pause:
        signal.pause()
    return should_pause


def squared_later(number):
    threading.Event().wait(0.005)
    return number * number


def ended(_):
    os.kill(os.getpid(), signal.SIGKILL)
