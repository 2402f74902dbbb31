"""Thread for the methods of a hand, so that the program never waits for one that blocks."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, wait
from queue import SimpleQueue

from firstcontact.grasp.hand import HandError
from firstcontact.grasp.separate import RELEASED

#: Longest wait for a call of the driver, s.
STUCK = 1.0


class DriverThread:
    """Thread that carries out calls in order. A call that blocks delays only later calls."""

    def __init__(self) -> None:
        self._calls: SimpleQueue[tuple[Callable[[], None], Future[None]] | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._newest: Future[None] | None = None

    def call(self, act: Callable[[], None], seconds: float = STUCK) -> BaseException | None:
        """Carry out a call, and return its error, or HandError after ``seconds`` s.

        While an earlier call blocks, times up to ``RELEASED`` count as 0: this call is carried out
        once that one returns.
        """
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="hand driver", daemon=True)
            self._thread.start()
        is_stuck = self._newest is not None and not self._newest.done()
        self._newest = done = Future[None]()
        self._calls.put((act, done))
        wait([done], 0.0 if is_stuck and seconds <= RELEASED else seconds)
        if not done.done():
            return HandError(
                "the hand's code did not return in time: disconnect the hand's power if it does "
                "not open"
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


def call_directly(act: Callable[[], None], seconds: float = STUCK) -> BaseException | None:
    """Carry out a call in this thread, and return its error. Interrupts are raised."""
    try:
        act()
    except BaseException as error:
        is_main = threading.current_thread() is threading.main_thread()
        if is_main and not isinstance(error, Exception):  # such as Ctrl-C
            raise
        return error
    return None
