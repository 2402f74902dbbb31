"""Workers: order of results, errors, and no process left behind."""

import os
import signal
import subprocess
import sys

import joblib
import numpy as np
import pytest
import threadpoolctl

from firstcontact.jobs.runners import ALIGNMENT, Serial, pack_payload, parallel, unpack_payload
from processes import children, command_line, gone, stop


def test_results_are_in_order_and_workers_end():
    ticks: list[tuple[int, int]] = []
    with parallel(2, lambda finished, total: ticks.append((finished, total))) as runner:
        assert runner.map(abs, [-1, 2, -3]) == Serial().map(abs, [-1, 2, -3]) == [1, 2, 3]
        pids = set(runner.map(_pid, [0, 1, 2, 3]))
    assert ticks[:3] == [(1, 3), (2, 3), (3, 3)]
    assert os.getpid() not in pids
    assert all(gone(pid) for pid in pids)


def test_every_job_gets_the_shared_value():
    shared = np.arange(1_000_000, dtype=np.float32)  # larger than what joblib maps
    expected = [float(shared[n]) for n in range(4)]
    assert Serial().map(_picked, range(4), shared, "of") == expected
    with parallel(2) as runner:
        assert runner.map(_picked, range(4), shared, "of") == expected
    with parallel(2, prefer="threads") as runner:
        assert runner.map(_picked, range(4), shared, "of") == expected
    with joblib.parallel_config("threading"), parallel(2) as runner:
        assert runner.map(_picked, range(4), shared, "of") == expected


def _picked(place, shared, word):
    assert word == "of"
    return float(shared[place])


@pytest.mark.parametrize("workers", [1, 2])
def test_each_job_has_one_thread(workers):
    environment = dict(os.environ)
    with parallel(workers) as runner:
        assert runner.map(_threads, range(2)) == [{1}, {1}]
    assert dict(os.environ) == environment


def _threads(_):
    np.linalg.inv(np.eye(3))
    return {library["num_threads"] for library in threadpoolctl.threadpool_info()}


def test_job_may_run_further_jobs():
    with parallel(2) as runner:
        assert runner.map(_inner_sum, range(3)) == [0, 2, 4]


def _inner_sum(number):
    with parallel(1) as runner:
        return sum(runner.map(abs, [number, -number]))


def test_abandoned_stream_ends_quietly():
    with parallel(2) as runner:
        stream = runner.stream(_pause, [False, True, True, True])
        assert next(stream) is False
        stream.close()
        assert runner.map(abs, [-2]) == [2]


def _pause(still):
    if still:
        signal.pause()
    return still


def _pid(_):
    return os.getpid()


def test_worker_error_ends_the_map_and_the_next_map_works():
    with parallel(2) as runner:
        with pytest.raises(ZeroDivisionError):
            runner.map((1.0).__truediv__, [1.0, 0.0, 1.0])
        assert runner.map((1.0).__truediv__, [1.0, 0.5]) == [1.0, 2.0]


PARENT = """
import sys
from firstcontact.jobs import parallel

def job(number, folder):
    # The first two begin together, so in two workers; the others keep Python's lock.
    import ctypes, pathlib
    if number > 1:
        ctypes.PyDLL(None).pause()
    (pathlib.Path(folder) / str(number)).touch()
    while not (pathlib.Path(folder) / str(1 - number)).exists():
        pass

if __name__ == "__main__":
    with parallel(2) as runner:
        import functools
        work = functools.partial(job, folder=sys.argv[1])
        print(*runner.map(work, [0, 1]), flush=True)
        runner.map(work, [2, 3, 4, 5])
"""


@pytest.mark.parametrize(
    ("number", "still"), [(signal.SIGKILL, True), (signal.SIGKILL, False), (signal.SIGINT, False)]
)
def test_workers_end_with_their_parent_during_a_job(number, still, tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", PARENT, tmp_path], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    ) as parent:
        assert parent.stdout.readline()
        workers = [pid for pid in children(parent.pid) if not tracks(pid)]
        assert len(workers) == 2
        if still:
            for worker in workers:
                stop(worker)
        parent.send_signal(number)
        assert all(gone(worker) for worker in workers)


def tracks(pid):
    """Return True if a process is the resource tracker of loky, which ends after the workers."""
    return b"resource_tracker" in command_line(pid)


def test_values_round_trip_as_views_of_the_payload():
    samples = [np.arange(n, dtype=kind) for n, kind in ((3, "f4"), (0, "i8"), (1000, "f8"))]
    names = np.array(["a", "", "long name"])
    turned = np.arange(12.0).reshape(3, 4).T
    payload = pack_payload((samples, names, turned, {"seed": 3}))
    unpacked, unpacked_names, unpacked_turned, options = unpack_payload(payload)
    for was, now in zip(
        [*samples, names, turned], [*unpacked, unpacked_names, unpacked_turned], strict=True
    ):
        np.testing.assert_array_equal(was, now)
        assert was.dtype == now.dtype
        assert not now.flags.writeable
    assert options == {"seed": 3}
    assert np.shares_memory(unpacked[2], payload)
    assert (unpacked[2].ctypes.data - payload.ctypes.data) % ALIGNMENT == 0
