"""Processes that tests start, stop and kill."""

import os
import resource
import select
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

#: Of a machine that does much else at the same time, s: only a failing test waits so long.
PATIENCE = 60.0
#: Runs a command with files of at most so many bytes, which is a full disk for what is larger.
ON_FULL_DISK = """
import resource, sys
from firstcontact.cli.main import main

resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]),) * 2)
sys.exit(main(sys.argv[2:]))
"""


def gone(pid: int) -> bool:
    """Return True if a process ends before the timeout."""
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        return True
    try:
        return bool(select.select([descriptor], [], [], PATIENCE)[0])
    finally:
        os.close(descriptor)


def until(reached: Callable[[], object]) -> None:
    """Poll until a condition is true."""
    tick = threading.Event()
    for _ in range(int(PATIENCE / 0.01)):
        if reached():
            return
        tick.wait(0.01)
    raise AssertionError("it did not come about")


@contextmanager
def full_disk(size: int) -> Iterator[None]:
    """Let the kernel refuse to write a file of this process beyond a size, as a full disk does."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    ignored = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, ignored)


def children(pid: int) -> list[int]:
    """Return the children of all threads of a process."""
    tasks = Path(f"/proc/{pid}/task").glob("*/children")
    collected: list[int] = []
    for task in tasks:
        with suppress(OSError):  # a thread that has ended meanwhile
            collected += [int(child) for child in task.read_text().split()]
    return sorted(collected)


def command_line(pid: int) -> bytes:
    """Return the command of a process, or an empty text if it has ended."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def stopped(pid: int) -> bool:
    """Return True if a process is stopped."""
    return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] == "T"


def stop(pid: int) -> None:
    """Stop a process until the context ends."""
    os.kill(pid, signal.SIGSTOP)
    until(lambda: stopped(pid))
