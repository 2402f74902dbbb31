"""Child processes that end when this process ends, even if it is killed.

``python -m firstcontact.jobs.children PARENT SIGNAL MODULE OPTIONS`` first asks the kernel to send
the child a signal when the parent ends. It then runs the module in the same process.
"""

from __future__ import annotations

import os
import runpy
import select
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from concurrent.futures import Future
from contextlib import suppress
from typing import IO, Any

#: Time to wait for a killed child, s. Only a child that is stuck in the kernel needs more.
KILLED = 5.0
#: Longest wait in one call of ``select``, s. It does not notice a signal that came just before it.
LONGEST_SELECT = 0.5


class Child:
    """Child process that runs a module, and exchanges lines with this process over pipes.

    If this process ends, the child is killed. With ``wakes``, it is only woken, and must end by
    itself.
    """

    def __init__(self, module: str, *options: str, wakes: bool = False) -> None:
        # SIGCONT wakes even a suspended child, which then notices the end of its input and exits.
        number = signal.SIGCONT if wakes else signal.SIGKILL
        started: Future[subprocess.Popen[bytes]] = Future()
        # The kernel treats the thread that starts a child as its parent, so the thread must live
        # as long as the child.
        self._keeper = threading.Thread(
            target=_keep,
            args=(started, module, options, number),
            name=f"keeper of {module}",
            daemon=True,
        )
        self._keeper.start()
        self._process = started.result()
        self._unread = b""

    @property
    def pid(self) -> int:
        return self._process.pid

    def tell(self, line: str, timeout: float) -> None:
        number = _open(self._process.stdin).fileno()
        data = line.encode() + b"\n"
        deadline = time.monotonic() + timeout
        while data:
            if not _wait_for_pipe(deadline, writes=[number]):
                raise TimeoutError(f"process {self.pid} reads no input: end and restart it")
            # A pipe that accepts data takes a short line whole.
            data = data[os.write(number, data[: select.PIPE_BUF]) :]

    def answer(self, timeout: float) -> str:
        """Return the next line that the child writes.

        Raises TimeoutError if none comes within ``timeout`` s, and BrokenPipeError if the child has
        ended.
        """
        number = _open(self._process.stdout).fileno()
        deadline = time.monotonic() + timeout
        while b"\n" not in self._unread:
            if not _wait_for_pipe(deadline, reads=[number]):
                raise TimeoutError(
                    f"process {self.pid} gave no answer in {timeout:g} s: end and restart it"
                )
            data = os.read(number, 4096)
            if not data:
                raise BrokenPipeError(f"process {self.pid} has ended: start it again")
            self._unread += data
        line, _, self._unread = self._unread.partition(b"\n")
        return line.decode("utf-8", "replace")

    def interrupt(self) -> None:
        """Send SIGTERM to the child."""
        self._process.terminate()

    def end_input(self) -> None:
        """Close the child's input, which tells the child to end. It may still send lines."""
        with suppress(OSError):
            _open(self._process.stdin).close()

    def end(self, timeout: float) -> bool:
        """Close the child's input, and kill the child if it still runs after ``timeout`` s.

        Return True if the child ended by itself and without an error.
        """
        self.end_input()
        self._keeper.join(timeout)
        killed = self._keeper.is_alive()
        if killed:
            with suppress(OSError):
                self._process.kill()
            self._keeper.join(KILLED)
        with suppress(OSError):
            _open(self._process.stdout).close()
        return not killed and self._process.returncode == 0


def _start_module(
    module: str, *options: str, number: signal.Signals, **popen: Any
) -> subprocess.Popen[bytes]:
    """Start a child process that runs a module. If this process ends, the child gets a signal.

    ``number`` is the number of that signal. ``options`` are the module's command-line options, and
    ``popen`` those of :class:`subprocess.Popen`.
    """
    # Without -P a file in the user's working folder could replace a module.
    command = [sys.executable, "-P", "-m", "firstcontact.jobs.children"]
    return subprocess.Popen(  # noqa: S603
        [*command, str(os.getpid()), str(int(number)), module, *options],
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(str, sys.path))},
        start_new_session=True,
        **popen,
    )


def _keep(
    started: Future[subprocess.Popen[bytes]],
    module: str,
    options: Sequence[str],
    number: signal.Signals,
) -> None:
    try:
        pipe = subprocess.PIPE
        process = _start_module(module, *options, number=number, stdin=pipe, stdout=pipe, bufsize=0)
    except BaseException as error:
        started.set_exception(error)
        return
    started.set_result(process)
    process.wait()


def _wait_for_pipe(
    deadline: float, *, reads: Sequence[int] = (), writes: Sequence[int] = ()
) -> bool:
    """Return True once one of the pipes can be read or written, False if ``deadline`` passes first.

    ``reads`` and ``writes`` are file descriptors. ``deadline`` is in s of ``time.monotonic()``.
    """
    while True:
        remaining = max(deadline - time.monotonic(), 0.0)
        if any(select.select(reads, writes, [], min(remaining, LONGEST_SELECT))):
            return True
        if remaining <= LONGEST_SELECT:
            return False


def _open(stream: IO[bytes] | None) -> IO[bytes]:
    if stream is None or stream.closed:
        raise BrokenPipeError("the child process has ended: start it again")
    return stream


def follow(parent: int, number: signal.Signals = signal.SIGKILL) -> None:
    """On Linux, make the kernel send this process a signal when its parent process ends.

    ``parent`` is the parent's process id. If the parent has ended already, the signal is sent now.
    """
    if sys.platform == "linux":
        import ctypes

        set_parent_death_signal = 1
        ctypes.CDLL(None).prctl(set_parent_death_signal, int(number), 0, 0, 0)
    if os.getppid() != parent:
        os.kill(os.getpid(), number)


def main() -> None:
    """Run the module that the command line names, in a process that ends with its parent."""
    parent, number, module, *options = sys.argv[1:]
    follow(int(parent), signal.Signals(int(number)))
    sys.argv = [module, *options]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
