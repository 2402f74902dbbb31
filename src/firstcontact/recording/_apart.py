"""Calls in a separate process, for libraries that may loop or crash on damaged files."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from firstcontact.core import start_module

T = TypeVar("T")


def apart(seconds: float, function: Callable[..., T], *arguments: object) -> T:
    """Call a function in another process and return its result, or raise its exception."""
    parent_end, child_end = multiprocessing.Pipe()
    # A process with threads cannot be forked safely. A new process takes some 0.3 s to start.
    if threading.active_count() == 1:
        process: Any = multiprocessing.get_context("fork").Process(
            target=_work, args=(child_end, function, arguments), daemon=True
        )
        process.start()
        wait = process.join
    else:
        # Unlike a process of multiprocessing, it does not run the user's script again.
        process = start_module(
            "firstcontact.recording._apart",
            str(child_end.fileno()),
            stdin=subprocess.DEVNULL,
            pass_fds=[child_end.fileno()],
        )
        parent_end.send((function, arguments))
        wait = process.wait
    child_end.close()
    try:
        if not parent_end.poll(seconds):
            raise OSError("the file is so damaged that reading it does not end")
        try:
            is_result, result = parent_end.recv()
        except (EOFError, ConnectionError):
            raise OSError("the file is so damaged that reading it crashes") from None
    finally:
        process.kill()
        wait()
        parent_end.close()
    if not is_result:
        raise result
    return result  # type: ignore[no-any-return]


def main() -> None:
    """Receive a function and its arguments, call it, and send the result."""
    connection = Connection(int(sys.argv[1]))
    function, arguments = connection.recv()
    _work(connection, function, arguments)


def _work(
    connection: Connection, function: Callable[..., object], arguments: tuple[object, ...]
) -> None:
    try:
        connection.send((True, function(*arguments)))
    except Exception as error:
        connection.send((False, error))


if __name__ == "__main__":
    main()
