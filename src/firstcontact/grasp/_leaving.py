"""Signals while a hand is open: the first lets go of it, and no other disturbs that."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from firstcontact.core import by_signal

#: Signals that end a process without a word, unless somebody takes them.
ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Who asks again after so long asks a program that went on after the first time, s.
INSISTED = 2.0


class Leaving:
    """Takes the signals that nobody else handles, from :meth:`take` to :meth:`give_back`.

    The first raises KeyboardInterrupt (SIGINT) or SystemExit where the main thread is. It is then
    on its way out of a ``with`` block, and another that comes meanwhile would keep it from letting
    go: so it waits. Only the main thread can do this; elsewhere nothing happens.

    Parameters
    ----------
    let_go
        Called with the first signal, in the main thread wherever that is: must be quick and safe
        to call at any point.
    """

    def __init__(self, let_go: Callable[[], None]) -> None:
        self._let_go = let_go
        self._taken: list[signal.Signals] = []
        self._at: float | None = None  # when the signal came that is on its way out
        self._waiting: list[int] | None = None  # signals that wait while this is held

    def take(self) -> None:
        """Take SIGINT where Python raises KeyboardInterrupt, others where the process just ends."""
        if threading.current_thread() is not threading.main_thread():
            return
        taken = [n for n in ENDING if signal.getsignal(n) is signal.SIG_DFL]
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            taken.append(signal.SIGINT)
        self._taken = taken
        for number in taken:
            signal.signal(number, self._came)

    def give_back(self) -> None:
        """Leave signals to whoever had them."""
        if threading.current_thread() is not threading.main_thread():
            return
        taken, self._taken = self._taken, []
        for number in taken:
            own = number == signal.SIGINT
            signal.signal(number, signal.default_int_handler if own else signal.SIG_DFL)

    def goes_on(self) -> None:
        """The program has caught the first and goes on: the next is a first again."""
        if self._at is not None and threading.current_thread() is threading.main_thread():
            self._at = None

    @contextmanager
    def held(self) -> Iterator[None]:
        """Hold back signals, whoever handles them, to the end of the block; then they happen."""
        came: list[int] = []
        before = {}
        self._waiting = came
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, *ENDING):
                if signal.getsignal(number) not in (signal.SIG_IGN, None, self._came):
                    before[number] = signal.signal(number, lambda n, frame: came.append(n))
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            self.give_back()
            self._waiting = None
            # One that came on the way out has the first's exception already.
            if came and self._at is None:
                signal.raise_signal(came[0])

    def _came(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._waiting is not None:
            self._waiting.append(number)
        elif self._at is None or now - self._at > INSISTED:
            self._at = now
            self._let_go()
            if number == signal.SIGINT:
                raise by_signal(KeyboardInterrupt())
            raise by_signal(SystemExit(128 + number))
