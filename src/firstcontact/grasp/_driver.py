"""Thread that calls the methods of a hand's driver, and does not wait for one that blocks."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from queue import SimpleQueue

from firstcontact.grasp.hand import HandError

#: Longest wait for a call of the driver, s.
STUCK = 1.0


class DriverThread:
    """Thread that carries out calls in their order. A call that blocks delays only later calls."""

    def __init__(self) -> None:
        self._calls: SimpleQueue[tuple[Callable[[], None], Future[None]] | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._is_stuck = False

    def call(self, act: Callable[[], None], seconds: float | None = None) -> BaseException | None:
        """Return the error of a call, or a HandError if it takes longer than ``seconds``.

        The default is ``STUCK``, but 0 after a call that took longer: this one is carried out once
        that one returns.
        """
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="hand driver", daemon=True)
            self._thread.start()
        if seconds is None:
            seconds = 0.0 if self._is_stuck else STUCK
        done: Future[None] = Future()
        self._calls.put((act, done))
        wait([done], seconds)
        self._is_stuck = not done.done()
        if self._is_stuck:
            return HandError(
                f"the hand's code did not return within {STUCK:g} s: disconnect the hand's power "
                "if it does not open"
            )
        return done.exception()

    def end(self) -> None:
        """End the thread after its last call."""
        self._calls.put(None)

    def _run(self) -> None:
        while (job := self._calls.get()) is not None:
            act, done = job
            try:
                act()
            except BaseException as error:  # SystemExit would end this thread silently
                done.set_exception(error)
            else:
                done.set_result(None)


def call_directly(act: Callable[[], None], seconds: float | None = None) -> BaseException | None:
    """Return the error of a call. An interrupt of the program is raised instead."""
    try:
        act()
    except BaseException as error:
        is_main = threading.current_thread() is threading.main_thread()
        if is_main and not isinstance(error, Exception):  # such as Ctrl-C
            raise
        return error
    return None
