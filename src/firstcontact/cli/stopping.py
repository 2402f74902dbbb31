"""Handlers that turn signals such as Ctrl-C into requests to stop, so that files get finished."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

#: Signals of Ctrl-C, the system, a closed terminal and Ctrl-\.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
#: Time after which a further signal ends the program immediately, s.
INSISTED = 5.0


class Stop:
    """Request to stop the program. A signal such as Ctrl-C sets it."""

    def __init__(self) -> None:
        self.signal: signal.Signals | None = None
        self.gently = False
        self._at = 0.0

    @property
    def requested(self) -> bool:
        return self.signal is not None

    @property
    def code(self) -> int:
        """Exit code of a stopped program, by the convention of shells: 130 for Ctrl-C."""
        return 128 + (self.signal or signal.SIGINT)

    def _take(self, number: int, frame: FrameType | None) -> None:
        first, now = self.signal is None, time.monotonic()
        # A second signal must not disturb the finishing, unless that hangs.
        if not first and now - self._at < INSISTED:
            return
        self._at = now
        self.signal = self.signal or signal.Signals(number)
        if not (first and self.gently):
            raise KeyboardInterrupt


_installed: list[Stop] = []


@contextmanager
def stop_on_signals() -> Iterator[Stop]:
    """Yield a request to stop, which the signals in :data:`SIGNALS` set in the ``with`` block."""
    if _installed:
        yield _installed[-1]
        return
    stop = Stop()
    _installed.append(stop)
    former = {}
    try:
        if threading.current_thread() is threading.main_thread():
            for number in SIGNALS:
                ignored = signal.getsignal(number) is signal.SIG_IGN
                if not ignored or number in (signal.SIGINT, signal.SIGTERM):
                    former[number] = signal.signal(number, stop._take)
        yield stop
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
        _installed.remove(stop)
