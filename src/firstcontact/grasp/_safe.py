"""Hand wrapper that releases the hand when the program fails."""

from __future__ import annotations

import atexit
import threading
import time
from collections.abc import Callable
from functools import partial
from math import inf
from typing import TYPE_CHECKING, Self

from firstcontact.core import Command, is_interrupt, summarize_error
from firstcontact.grasp._hand import Hand, HandError
from firstcontact.grasp._leaving import Leaving
from firstcontact.grasp._pacing import HandCounts, Pacer

if TYPE_CHECKING:
    from firstcontact.core import ClosingSpeed

#: Longest wait of a signal handler for the watchdog thread, s.
PROMPT = 0.1


class SafeHand(Hand):
    """Wrapper that limits, paces and watches any hand. It is a hand itself.

    Commands are clipped to the hand's limits and sent no faster than the hand accepts them. A newer
    command replaces a waiting one, and the last command is always sent. A watchdog thread repeats
    the last command before the hand's own watchdog runs out. It releases the hand when the program
    has been silent. It tries a failed release again, each time after ``silence``.

    The hand is also released

    - when the ``with`` block ends, in any way,
    - when the interpreter exits,
    - when the hand fails,
    - immediately on Ctrl-C, SIGTERM, SIGHUP and SIGQUIT, unless the program handles them. Then
      KeyboardInterrupt or SystemExit is raised in the main thread.

    A second signal within 2 s is ignored. Signals during closing wait until the hand is closed. The
    watchdog thread needs Python's global interpreter lock (GIL). If other code may keep this lock,
    use :class:`firstcontact.grasp._separate.SeparateHand`.

    Parameters
    ----------
    hand
        Hand that is not open yet. The wrapper opens and closes it.
    silence
        Time without :meth:`send` or :meth:`alive` after which the hand is released, s.
    clock
        Monotonic clock, s.

    Raises
    ------
    InputError
        ``silence`` is not above 0.
    """

    def __init__(
        self, hand: Hand, *, silence: float = 1.0, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.name = hand.name  # type: ignore[misc]  # same as the wrapped hand
        self.limits = hand.limits
        self.begins = hand.begins  # type: ignore[misc]
        self._hand = hand
        self._clock = clock
        self._pacer = Pacer(hand.limits, silence)
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        self._failure: HandError | None = None
        self._release_requested = False  # set by a signal handler
        self._leaving = Leaving(self._let_go)

    @property
    def counts(self) -> HandCounts:
        """Counts of the commands so far."""
        return self._pacer.counts

    @property
    def failure(self) -> HandError | None:
        """Error that stopped the hand; None while it takes commands."""
        return self._failure

    @property
    def wait(self) -> float:
        """Time until the hand takes a command that is given now, s."""
        return self._pacer.wait(self._clock())

    def send(self, command: Command) -> None:
        """Set the command, which replaces a command that still waits.

        Raises
        ------
        HandError
            The command is not finite, and the hand was released for that reason; or the hand is not
            open, or has failed.
        """
        self._leaving.rearm()
        with self._change:
            self._check()
            try:
                self._pacer.offer(command, self._clock())
            except ValueError as error:
                self._release()
                raise HandError(f"{error}; the hand was released") from error
            self._act()
            self._change.notify()
            self._check()

    def start(self) -> None:
        """Begin the next closing immediately.

        Raises
        ------
        HandError
            As in :meth:`send`.
        """
        with self._change:
            self._check()
            if not self._attempt(self._hand.start):
                self._release()
                self._check()

    def alive(self) -> None:
        """Confirm that the program runs and the last command still holds.

        Raises
        ------
        HandError
            As in :meth:`send`.
        """
        self._leaving.rearm()
        with self._change:
            self._check()
            self._pacer.alive(self._clock())

    def closing_speed(self, sample_time: float, host_time: float) -> ClosingSpeed | None:
        """Return the closing speed of the hand before a contact; None if it is not known.

        Raises
        ------
        HandError
            As in :meth:`send`, or the hand failed in this call and was released.
        """
        measured: list[ClosingSpeed | None] = []

        def measure() -> None:
            measured.append(self._hand.closing_speed(sample_time, host_time))

        with self._change:
            self._check()
            if not self._attempt(measure):
                self._release()
                self._check()
        return measured[0]

    def release(self) -> None:
        """Open the hand now, and keep it open until the next command."""
        with self._change:
            if not self._closed:
                self._release()

    def close(self) -> None:
        """Release and close the hand. Closing twice is allowed."""
        # A second signal must not interrupt the release that the first one started.
        with self._leaving.deferred():
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
            raise HandError(f"the hand {self.name!r} can be opened only once: make a new one")
        # A program with its own signal handlers leaves its ``with`` blocks by itself.
        self._leaving.take()
        try:
            self._hand.__enter__()
            atexit.register(self.close)
            thread = threading.Thread(target=self._watch, name="hand watchdog", daemon=True)
            thread.start()
            self._thread = thread
        except BaseException:  # a signal too: no ``with`` block closes the hand yet
            self.close()
            raise
        return self

    def _let_go(self) -> None:
        """Make the watchdog thread release the hand."""
        self._release_requested = True
        if self._change.acquire(timeout=PROMPT):
            self._change.notify()
            self._change.release()

    def _check(self) -> None:
        if self._closed or self._thread is None:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        if self._failure is not None:
            raise HandError(f"the hand {self.name!r} failed: {self._failure}") from self._failure

    def _release(self) -> bool:
        """Release the hand. Return True on success."""
        self._pacer.release()
        return self._open_hand()

    def _open_hand(self) -> bool:
        """Open the hand. If this fails, the watchdog thread tries again. Return True on success."""
        is_open = self._attempt(self._hand.release)
        if not is_open:
            self._pacer.retry_release(self._clock())
            self._change.notify()
        return is_open

    def _attempt(self, act: Callable[[], None]) -> bool:
        """Call a method of the hand. Store an error, so that the watchdog thread continues."""
        try:
            act()
        except BaseException as error:
            if is_interrupt(error):
                raise
            if not isinstance(error, HandError):
                error = HandError(f"the hand's code raised {summarize_error(error)}")
            self._failure = error
            return False
        return True

    def _act(self) -> None:
        """Carry out the action of the pacer that is due."""
        if self._release_requested:
            self._release_requested = False
            self._release()
        due = self._pacer.due(self._clock())
        if due is None:
            return
        if due.command is None:
            self._open_hand()
        elif not self._attempt(partial(self._hand.send, due.command)):
            self._release()

    def _watch(self) -> None:
        with self._change:
            while not self._closed:
                self._act()
                wait = self._pacer.next_time() - self._clock()
                self._change.wait(None if wait == inf else max(wait, 0.0))
