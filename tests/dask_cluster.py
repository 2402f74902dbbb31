"""A Dask cluster on this machine, whose workers tests may kill."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from processes import until


@dataclass(frozen=True)
class Cluster:
    """Address and processes of a cluster."""

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: tuple[subprocess.Popen[bytes], ...]


@contextmanager
def cluster(folder: Path, workers: int, first_on_path: Path | None = None) -> Iterator[Cluster]:
    """Start a scheduler and workers of one thread each, and stop them at the end.

    Parameters
    ----------
    folder
        Empty folder for the files of the scheduler and the workers.
    workers
        Number of workers.
    first_on_path
        Folder that comes first on the workers' import path.
    """
    paths = [str(first_on_path or folder), *sys.path]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
    text = folder / "scheduler.json"

    def started(*words: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", *words, "--no-dashboard"]
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=log
        )
        stack.callback(process.wait)
        stack.callback(process.kill)
        return process

    with ExitStack() as stack, (folder / "log").open("wb") as log:
        location = ("--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(text))
        scheduler = started("scheduler", *location)
        until(lambda: text.is_file() and text.read_text("utf-8").rstrip().endswith("}"))
        address = json.loads(text.read_text(encoding="utf-8"))["address"]
        worker = ("worker", address, "--host", "127.0.0.1", "--nthreads", "1", "--no-nanny")
        processes = tuple(started(*worker) for _ in range(workers))
        # Each says so when it is registered.
        until(lambda: (folder / "log").read_bytes().count(b"Registered to:") >= workers)
        yield Cluster(address, scheduler, processes)
