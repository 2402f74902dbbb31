"""Commands on a cluster: equal files, a killed worker, an interrupt, an invalid address."""

import asyncio
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from dask_cluster import Cluster, cluster
from firstcontact.twin.simulation import simulate_recordings
from processes import children, until


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """Return the address of a cluster with one worker. No test may stop the cluster."""
    with cluster(tmp_path_factory.mktemp("cluster"), 1) as running:
        yield running


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


async def processing(address: str) -> dict[str, list[str]]:
    """Ask the scheduler for the tasks of each worker, without connecting as a client."""
    from distributed import rpc

    async with rpc(address) as scheduler:
        tasks: dict[str, list[str]] = await scheduler.processing(workers=None)
        return tasks


def test_a_set_is_the_same_to_the_byte_though_a_worker_is_killed(tmp_path: Path) -> None:
    from firstcontact.jobs import use_cluster

    simulate_recordings(tmp_path / "here", "everyday", 6, 1, 3)
    made = 0

    with cluster(tmp_path, 2) as two:

        def progress(finished: int) -> None:
            nonlocal made
            made += finished
            if made == 5:
                two.workers[0].kill()
                two.workers[0].wait()

        with use_cluster(two.address):
            simulate_recordings(tmp_path / "there", "everyday", 6, 1, 3, progress=progress)
        assert two.workers[1].poll() is None
    assert contents(tmp_path / "there") == contents(tmp_path / "here")


def test_an_interrupt_leaves_neither_processes_nor_work_behind(
    one: Cluster, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    command = ["simulate", "--out", str(out), "--cluster", one.address]
    process = subprocess.Popen(
        [sys.executable, "-m", "firstcontact.cli.main", *command], stderr=subprocess.PIPE, text=True
    )
    until(lambda: list(tmp_path.glob(".out.*/out/*.mcap")))
    assert not children(process.pid)
    process.send_signal(signal.SIGINT)
    last = process.communicate()[1].splitlines()[-1]
    assert last == "firstcontact: interrupted"
    assert not list(tmp_path.glob("*out*"))
    assert process.returncode == 128 + signal.SIGINT
    until(lambda: not any(asyncio.run(processing(one.address)).values()))
    assert one.workers[0].poll() is None
