"""Ctrl-C and its kin as a request, so that what is being written can be finished."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from firstcontact.core import by_signal

#: Ctrl-C, the system, a terminal that is closed, Ctrl-\; not all systems have them all.
NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
#: Who asks again after so long wants the finishing cut short, s.
INSISTED = 5.0


class Stop:
    """Whether the process was asked to stop.

    Attributes
    ----------
    signal
        The one that came first; None while there was none.
    gently
        While it is true a signal is only noted, for a loop that looks at
        ``requested``; otherwise it raises KeyboardInterrupt where the program is.
    """

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self.gently = False
        self._at = 0.0

    @property
    def requested(self) -> bool:
        """Whether a signal came."""
        return self.signal is not None

    @property
    def code(self) -> int:
        """The exit code of a program that was asked to stop: 130 for Ctrl-C, as shells have it."""
        return 128 + (self.signal or signal.SIGINT)

    def _take(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self.signal is None:
            self.signal, self._at = signal.Signals(number), now
            if self.gently:
                return
        # A second signal must not disturb the finishing that the first began, unless that hangs.
        elif now - self._at < INSISTED:
            return
        else:
            self._at = now
        raise by_signal(KeyboardInterrupt())


_installed: list[Stop] = []


@contextmanager
def stopping() -> Iterator[Stop]:
    """Take the signals of :data:`NAMES` until the end of the block; inside another, its Stop.

    A SIGHUP or SIGQUIT that is ignored stays so (``nohup``). Outside of the main thread there are
    no signals to take.
    """
    if _installed:
        yield _installed[-1]
        return
    stop = Stop()
    _installed.append(stop)
    before = {}
    try:
        if threading.current_thread() is threading.main_thread():
            for number in (getattr(signal, name) for name in NAMES if hasattr(signal, name)):
                ignored = signal.getsignal(number) is signal.SIG_IGN
                if not ignored or number in (signal.SIGINT, signal.SIGTERM):
                    before[number] = signal.signal(number, stop._take)
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _installed.remove(stop)
