"""A hand that lets go when the program fails."""

from __future__ import annotations

import atexit
import threading
import time
from collections.abc import Callable
from functools import partial
from math import inf
from typing import Self

from firstcontact.core import Command, in_a_line, is_interrupt
from firstcontact.grasp._hand import Hand, HandError
from firstcontact.grasp._leaving import Leaving
from firstcontact.grasp._pacing import HandCounts, Pacer

#: A signal's handler waits so long for the thread to take notice, s.
PROMPT = 0.1


class SafeHand(Hand):
    """Any hand, made safe; a hand itself.

    Commands are clipped to the hand's limits and sent no faster than it takes them: the
    newest wins, and the last one is always sent. A thread repeats the last command
    before the hand's own watchdog runs out, and releases the hand when the program has been
    silent. The hand is released, too, on leaving the ``with`` block by any way, at the
    interpreter's exit, when the hand fails, and at once on Ctrl-C, SIGTERM, SIGHUP and SIGQUIT
    where nobody else handles them (then KeyboardInterrupt or SystemExit is raised in the main
    thread). Signals that come from then on, or while it is being closed, wait until it is closed.
    That thread needs Python's lock: for code that keeps it, see
    :class:`firstcontact.grasp._separate.SeparateHand`.

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
        self.begins = hand.begins  # type: ignore[misc]
        self._hand = hand
        self._clock = clock
        self._pacer = Pacer(hand.limits, silence)
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        self._failure: HandError | None = None
        self._asked = False  # by a signal to release
        self._leaving = Leaving(self._let_go)

    @property
    def counts(self) -> HandCounts:
        """What became of the commands so far."""
        return self._pacer.counts

    @property
    def failure(self) -> HandError | None:
        """Why the hand takes no commands any more; None while it does."""
        return self._failure

    @property
    def wait(self) -> float:
        """How long a command that is given now waits until the hand takes it, s."""
        return self._pacer.wait(self._clock())

    def send(self, command: Command) -> None:
        """Order; what waits is overtaken.

        Raises
        ------
        HandError
            The command is not finite (the hand was released), or the hand is not
            open or has failed.
        """
        self._leaving.goes_on()
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
        self._leaving.goes_on()
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
        # A second signal must not disturb the releasing that the first began.
        with self._leaving.held():
            self._end()

    def _end(self) -> None:
        with self._change:
            if self._closed:
                return
            self._closed = True
            released = self._thread is None or self._release()
            self._change.notify()
        atexit.unregister(self.close)
        try:
            if self._thread is not None:
                self._thread.join()
        finally:
            self._hand.close()
        if not released:
            raise HandError(f"the hand {self.name!r} was not released: {self._failure}")

    def __enter__(self) -> Self:
        if self._closed or self._thread is not None:
            raise HandError(f"the hand {self.name!r} can be opened once")
        # A program that handles a signal ends its blocks by itself, and with them this one.
        self._leaving.take()
        try:
            self._hand.__enter__()
            atexit.register(self.close)
            thread = threading.Thread(target=self._watch, name="hand watchdog", daemon=True)
            thread.start()
            self._thread = thread
        except BaseException:  # a signal, too: there is no block yet to be left
            self.close()
            raise
        return self

    def _let_go(self) -> None:
        """Have the thread release: this one may be in the middle of anything."""
        self._asked = True
        if self._change.acquire(timeout=PROMPT):
            self._change.notify()
            self._change.release()

    def _check(self) -> None:
        if self._closed or self._thread is None:
            raise HandError(f"the hand {self.name!r} is not open")
        if self._failure is not None:
            raise HandError(f"the hand {self.name!r} failed: {self._failure}") from self._failure

    def _release(self) -> bool:
        """Have the hand let go, and return True if it did."""
        self._pacer.release()
        return self._did(self._hand.release)

    def _did(self, act: Callable[[], None]) -> bool:
        """Have the hand act, and note what it raises: the watchdog must not end by that."""
        try:
            act()
        except BaseException as error:
            if is_interrupt(error):
                raise
            if not isinstance(error, HandError):
                error = HandError(f"it raised {in_a_line(error)}")
            self._failure = error
            return False
        return True

    def _act(self) -> None:
        """Do what is due."""
        if self._asked:
            self._asked = False
            self._release()
        due = self._pacer.due(self._clock())
        if due is None:
            return
        if due.command is None:
            self._did(self._hand.release)
        elif not self._did(partial(self._hand.send, due.command)):
            self._release()

    def _watch(self) -> None:
        with self._change:
            while not self._closed:
                self._act()
                wait = self._pacer.next_time() - self._clock()
                self._change.wait(None if wait == inf else max(wait, 0.0))
