"""Processes of ours that end with this one, however it ends."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from typing import IO

#: A child that was killed is waited for so long, s: only one that the kernel holds needs more.
KILLED = 5.0


class Child:
    """A process that runs a module, talked to by lines on its standard input and output.

    Closing its input is the request to end; it is in a session of its own, so that signals to the
    terminal's group are not for it.

    Parameters
    ----------
    module
        Run as ``python -m`` would.
    options
        Its command line.
    wakes
        It is to end by itself when its input ends, and is only woken if it was stopped; otherwise
        it is killed as soon as this process is gone.
    """

    def __init__(self, module: str, *options: str, wakes: bool = False) -> None:
        number = signal.SIGCONT if wakes else signal.SIGKILL
        words = [str(os.getpid()), str(int(number)), module, *options]
        started: Future[subprocess.Popen[bytes]] = Future()
        # The kernel takes the thread that starts a child for its parent: this one stays with it.
        self._keeper = threading.Thread(
            target=_keep, args=(words, started), name=f"keeper of {module}", daemon=True
        )
        self._keeper.start()
        try:
            self._process = started.result()
        except BaseException:
            # Ctrl-C while it is being started: it is not there yet, and must not come to stay.
            if not started.cancel() and started.exception() is None:
                started.result().kill()
            self._keeper.join(KILLED)
            raise
        self._said = b""

    def __del__(self) -> None:
        # Whoever made it was interrupted before it could be given a name.
        if self._keeper.is_alive() and hasattr(self, "_process"):
            with suppress(OSError):
                self._process.kill()

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    def tell(self, line: str, timeout: float) -> None:
        """Send a line.

        Raises
        ------
        OSError
            It has ended, or has not taken it within ``timeout`` s (TimeoutError).
        """
        number = _open(self._process.stdin).fileno()
        data = line.encode() + b"\n"
        until = time.monotonic() + timeout
        while data:
            left = max(until - time.monotonic(), 0.0)
            if not select.select([], [number], [], left)[1]:
                raise TimeoutError(f"process {self.pid} does not listen")
            # The pipe takes a short line whole where it takes anything.
            data = data[os.write(number, data[: select.PIPE_BUF]) :]

    def answer(self, timeout: float) -> str:
        """The next line that it says.

        Raises
        ------
        OSError
            It has ended, or said nothing for ``timeout`` s (TimeoutError).
        """
        number = _open(self._process.stdout).fileno()
        until = time.monotonic() + timeout
        while b"\n" not in self._said:
            left = max(until - time.monotonic(), 0.0)
            if not select.select([number], [], [], left)[0]:
                raise TimeoutError(f"process {self.pid} does not answer")
            data = os.read(number, 4096)
            if not data:
                raise BrokenPipeError(f"process {self.pid} has ended")
            self._said += data
        line, _, self._said = self._said.partition(b"\n")
        return line.decode("utf-8", "replace")

    def end(self, patience: float) -> bool:
        """Close its input, and kill it if it does not end within ``patience`` s.

        Returns
        -------
        bool
            Whether it ended by itself. Ending it twice is fine.
        """
        with suppress(OSError):
            _open(self._process.stdin).close()
        self._keeper.join(patience)
        killed = self._keeper.is_alive()
        if killed:
            with suppress(OSError):
                self._process.kill()
            self._keeper.join(KILLED)
        with suppress(OSError):
            _open(self._process.stdout).close()
        return not killed


def _keep(words: list[str], started: Future[subprocess.Popen[bytes]]) -> None:
    try:
        process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-m", "firstcontact.core._die_with_parent", *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,
        )
    except BaseException as error:
        started.set_exception(error)
        return
    try:
        started.set_result(process)
    except InvalidStateError:  # nobody wants it any more
        process.kill()
    process.wait()


def _open(stream: IO[bytes] | None) -> IO[bytes]:
    if stream is None or stream.closed:
        raise BrokenPipeError("the process has been ended")
    return stream
