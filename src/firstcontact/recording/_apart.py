"""A library at work on a stranger's file, in a process of its own: it may loop, or crash."""

from __future__ import annotations

import multiprocessing
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

T = TypeVar("T")


def apart(seconds: float, function: Callable[..., T], *arguments: object) -> T:
    """What a function returns, or raises, when it is called in another process.

    Parameters
    ----------
    seconds
        Longest time that it may take; then it is killed, s.
    function
        Of a module, as are the types of what it takes and gives.
    arguments
        Of the function.

    Raises
    ------
    OSError
        It took longer, or its process has crashed.
    """
    # A process with threads cannot be copied safely; a new one takes a second to begin.
    alone = threading.active_count() == 1 and "fork" in multiprocessing.get_all_start_methods()
    context: Any = multiprocessing.get_context("fork" if alone else "spawn")
    mine, its = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(its, function, arguments), daemon=True)
    process.start()
    its.close()
    try:
        if not mine.poll(seconds):
            raise OSError("it is so damaged that reading it does not end")
        try:
            done, result = mine.recv()
        except EOFError:
            raise OSError("it is so damaged that reading it crashes") from None
    finally:
        process.kill()
        process.join()
        mine.close()
    if not done:
        raise result
    return result  # type: ignore[no-any-return]


def _work(its: Connection, function: Callable[..., object], arguments: tuple[object, ...]) -> None:
    try:
        its.send((True, function(*arguments)))
    except Exception as error:
        its.send((False, error))
