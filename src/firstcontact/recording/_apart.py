"""Calls in a separate process, for libraries that may loop or crash on damaged files."""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

T = TypeVar("T")


def apart(seconds: float, function: Callable[..., T], *arguments: object) -> T:
    """Call a function in another process and return its result, or raise its exception.

    Parameters
    ----------
    seconds
        Longest time for the call, s. After it the process is killed.
    function
        Function at the top level of a module, so that it can be pickled. The types of its arguments
        and results must be pickleable, too.
    arguments
        Arguments of the function.

    Raises
    ------
    OSError
        The call took longer than ``seconds``, or its process crashed.
    """
    # A process with threads cannot be forked safely. A new process takes a second to start.
    alone = threading.active_count() == 1 and "fork" in multiprocessing.get_all_start_methods()
    context: Any = multiprocessing.get_context("fork" if alone else "spawn")
    parent_end, child_end = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(child_end, function, arguments), daemon=True)
    process.start()
    child_end.close()
    try:
        if not parent_end.poll(seconds):
            raise OSError("the file is so damaged that reading it does not end")
        try:
            is_result, result = parent_end.recv()
        except EOFError:
            raise OSError("the file is so damaged that reading it crashes") from None
    finally:
        process.kill()
        process.join()
        parent_end.close()
    if not is_result:
        raise result
    return result  # type: ignore[no-any-return]


def _work(
    connection: Connection, function: Callable[..., object], arguments: tuple[object, ...]
) -> None:
    try:
        connection.send((True, function(*arguments)))
    except Exception as error:
        connection.send((False, error))
