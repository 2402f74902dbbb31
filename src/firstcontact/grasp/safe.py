"""A hand that lets go when the program fails."""

from __future__ import annotations

import atexit
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import inf
from types import FrameType
from typing import Self

from firstcontact.core import Command
from firstcontact.grasp.hand import Hand, HandError
from firstcontact.grasp.pacing import HandCounts, Pacer

Handler = Callable[[int, FrameType | None], None] | signal.Handlers

#: Signals that end a process without a word, unless somebody takes them.
ENDING = (signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


def _leave(number: int, frame: FrameType | None) -> None:
    raise SystemExit(128 + number)


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Hold back what would end the program until the end of the block; then it is let happen."""
    came: list[int] = []
    before = {}
    # Only the main thread may, and only it is interrupted.
    if threading.current_thread() is threading.main_thread():
        for number in (signal.SIGINT, *ENDING):
            if signal.getsignal(number) not in (signal.SIG_IGN, None):
                before[number] = signal.signal(number, lambda n, frame: came.append(n))
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


class SafeHand(Hand):
    """Any hand, made safe; a hand itself.

    Commands are clipped to the hand's limits and sent no faster than it takes them: the
    newest wins, and the last one is always sent. A thread repeats the last command
    before the hand's own watchdog runs out, and releases the hand when the program has been
    silent. The hand is released, too, on leaving the ``with`` block by any way, at the
    interpreter's exit, when the hand fails, and on SIGTERM, SIGHUP and SIGQUIT where nobody else
    handles them (then SystemExit is raised in the main thread). While it is being closed signals
    wait. That thread needs Python's lock: for code that keeps it, see
    :class:`firstcontact.grasp.separate.SeparateHand`.

    Parameters
    ----------
    hand
        Not open yet; it is opened and closed with this one.
    silence
        Time without :meth:`send` or :meth:`alive` after which the hand is released, s.
    clock
        Seconds that only go forward.
    """

    def __init__(
        self, hand: Hand, *, silence: float = 1.0, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.name = hand.name  # type: ignore[misc]  # as what is inside
        self.limits = hand.limits
        self._hand = hand
        self._clock = clock
        self._pacer = Pacer(hand.limits, silence)
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        self._failure: Exception | None = None
        self._taken: list[signal.Signals] = []

    @property
    def counts(self) -> HandCounts:
        """What became of the commands so far."""
        return self._pacer.counts

    @property
    def failure(self) -> Exception | None:
        """Why the hand takes no commands any more; None while it does."""
        return self._failure

    def send(self, command: Command) -> None:
        """Order; what waits is overtaken.

        Raises
        ------
        HandError
            The command is not finite (the hand was released), or the hand is not
            open or has failed.
        """
        with self._change:
            self._check()
            try:
                self._pacer.offer(command, self._clock())
            except ValueError as error:
                self._release()
                raise HandError(f"{error}: it was released") from error
            self._act()
            self._change.notify()
            self._check()

    def alive(self) -> None:
        """Say that the program is there and what was ordered still holds.

        Raises
        ------
        HandError
            As in :meth:`send`.
        """
        with self._change:
            self._check()
            self._pacer.alive(self._clock())

    def release(self) -> None:
        """Open and let go now, until the next command."""
        with self._change:
            if not self._closed:
                self._release()

    def close(self) -> None:
        """Release, and let go of the hand; closing twice is fine."""
        try:
            # A second signal must not disturb the releasing that the first began.
            with _undisturbed():
                self._end()
        finally:
            self._handle(signal.SIG_DFL)

    def _end(self) -> None:
        with self._change:
            if self._closed:
                return
            self._closed = True
            if self._thread is not None:
                self._release()
            self._change.notify()
        atexit.unregister(self.close)
        try:
            if self._thread is not None:
                self._thread.join()
        finally:
            self._hand.close()

    def __enter__(self) -> Self:
        if self._closed or self._thread is not None:
            raise HandError(f"the hand {self.name!r} can be opened once")
        # A program that handles a signal ends its blocks by itself, and with them this one.
        self._taken = [n for n in ENDING if signal.getsignal(n) is signal.SIG_DFL]
        self._handle(_leave)
        try:
            self._hand.__enter__()
        except BaseException:
            self._handle(signal.SIG_DFL)
            raise
        atexit.register(self.close)
        self._thread = threading.Thread(target=self._watch, name="hand watchdog", daemon=True)
        self._thread.start()
        return self

    def _handle(self, handler: Handler) -> None:
        # Only the main thread may; elsewhere the program's end is its own affair.
        if threading.current_thread() is threading.main_thread():
            for number in self._taken:
                signal.signal(number, handler)
            if handler is signal.SIG_DFL:
                self._taken = []

    def _check(self) -> None:
        if self._closed or self._thread is None:
            raise HandError(f"the hand {self.name!r} is not open")
        if self._failure is not None:
            raise HandError(f"the hand {self.name!r} failed: {self._failure}") from self._failure

    def _release(self) -> None:
        self._pacer.release()
        self._hand.release()

    def _act(self) -> None:
        """Do what is due."""
        due = self._pacer.due(self._clock())
        if due is None:
            return
        if due.command is None:
            self._hand.release()
            return
        try:
            self._hand.send(due.command)
        except Exception as error:
            self._failure = error
            self._release()

    def _watch(self) -> None:
        with self._change:
            while not self._closed:
                self._act()
                wait = self._pacer.next_time() - self._clock()
                self._change.wait(None if wait == inf else max(wait, 0.0))
