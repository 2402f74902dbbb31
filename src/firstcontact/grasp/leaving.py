"""Signal handlers while a hand is open: a second signal must not stop the hand's release."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

#: Signals that end a process silently unless it handles them.
ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Time from a signal until the next one counts as a first signal again, s: by then the program has
#: handled the earlier one.
INSISTED = 2.0


class Leaving:
    """Handlers of the signals that would otherwise end the program while a hand is open."""

    def __init__(self, let_go: Callable[[], None]) -> None:
        self._let_go = let_go
        self._taken: list[signal.Signals] = []
        self._at: float | None = None  # time of the signal whose exception is being handled
        self._waiting: list[int] | None = None  # signals deferred until the block ends

    def install(self) -> None:
        """Install the handlers, for those signals that the program does not handle itself."""
        if threading.current_thread() is not threading.main_thread():
            return
        taken = [n for n in ENDING if signal.getsignal(n) is signal.SIG_DFL]
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            taken.append(signal.SIGINT)
        self._taken = taken
        _ACTIVE.append(self)
        for number in taken:
            signal.signal(number, self._on_signal)

    def give_back(self) -> None:
        """Restore the default handlers, or leave the signals to another hand that is open."""
        if self in _ACTIVE:
            _ACTIVE.remove(self)
        if threading.current_thread() is not threading.main_thread():
            return
        taken, self._taken = self._taken, []
        heir = _ACTIVE[-1] if _ACTIVE else None
        if heir is not None and taken:
            heir._at, heir._taken = self._at, heir._taken + taken
        for number in taken:
            is_interrupt = number == signal.SIGINT
            default = signal.default_int_handler if is_interrupt else signal.SIG_DFL
            signal.signal(number, default if heir is None else heir._on_signal)

    def rearm(self) -> None:
        """Forget earlier signals, because the program handled them.

        The next one counts as first.
        """
        if self._at is not None and threading.current_thread() is threading.main_thread():
            self._at = None

    @contextmanager
    def deferred(self) -> Iterator[None]:
        """Defer signals that end the program until the ``with`` block ends.

        This includes signals that the program handles.
        """
        deferred: list[int] = []
        handlers = {}
        self._waiting = deferred
        if threading.current_thread() is threading.main_thread():
            for number in (signal.SIGINT, *ENDING):
                if signal.getsignal(number) not in (signal.SIG_IGN, None, self._on_signal):
                    handlers[number] = signal.signal(number, lambda n, frame: deferred.append(n))
        try:
            yield
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
            self.give_back()
            self._waiting = None
            # If a signal before the block raised its exception, the deferred ones raise none.
            if deferred and self._at is None:
                signal.raise_signal(deferred[0])

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._waiting is not None:
            self._waiting.append(number)
        elif self._at is None or now - self._at > INSISTED:
            self._at = now
            for leaving in tuple(_ACTIVE):
                leaving._let_go()
            if number == signal.SIGINT:
                raise KeyboardInterrupt
            raise SystemExit(128 + number)


#: Active objects, in the order in which they became active.
_ACTIVE: list[Leaving] = []
