"""Wrapper of a hand that opens the hand when the program fails or hangs."""

from __future__ import annotations

import atexit
import logging
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, wait
from functools import partial
from math import inf
from queue import SimpleQueue
from typing import TYPE_CHECKING, Self

from firstcontact.core import Command
from firstcontact.core.text import summarize_error
from firstcontact.grasp.hand import (
    Hand,
    HandError,
    check_positions,
    steady_clock,
)
from firstcontact.grasp.leaving import Leaving
from firstcontact.grasp.pacing import HandCounts, Pacer
from firstcontact.grasp.separate import ENDED, MUTE, RELEASED, SeparateHand

if TYPE_CHECKING:
    from firstcontact.core import ClosingSpeed

#: Longest wait for a call of the driver, s.
STUCK = 1.0
#: Longest wait of a signal handler for the watchdog thread, s.
PROMPT = 0.1

_log = logging.getLogger("firstcontact.grasp")


class SafeHand(Hand):
    """Wrapper of a hand that limits and paces its commands, and lets go if the program hangs.

    Commands are clipped to the hand's limits and sent no faster than the hand accepts them. A newer
    command replaces one that still waits, so the hand always gets the last one. A watchdog thread
    repeats the last command before the hand's own watchdog runs out. It releases (opens) the hand
    ``silence`` s after the last call of :meth:`send` or :meth:`alive`, and retries if this fails.
    The hand then stays open until :meth:`release` is called: a program that was suspended must not
    close it by a command from before.

    The hand is also released

    - when the ``with`` block ends, in any way,
    - when the interpreter exits,
    - when the hand fails,
    - immediately on Ctrl-C, SIGTERM, SIGHUP and SIGQUIT, unless the program handles them. Then
      KeyboardInterrupt or SystemExit is raised in the main thread.

    A second signal within 2 s is ignored. Signals during closing wait until the hand is closed. The
    watchdog thread needs Python's global interpreter lock (GIL). If other code may hold this lock
    for long, set :attr:`Hand.separate`.

    Methods that command or read the hand raise :class:`HandError` if it is not open or has failed.
    A method of ``hand`` that does not return within 1 s counts as failed, ``release`` after 3 s.
    While a method runs, another thread may call those that read the hand.

    Parameters
    ----------
    hand
        Hand that is not connected yet. The wrapper connects it, and closes the connection.
    silence
        Time without :meth:`send` or :meth:`alive` after which the hand is released, s.
    clock
        Clock, s, which goes on while the computer sleeps.

    Raises
    ------
    InputError
        ``silence`` is not above 0.
    """

    def __init__(
        self, hand: Hand, *, silence: float = 1.0, clock: Callable[[], float] = steady_clock
    ) -> None:
        self.name = hand.name  # type: ignore[misc]  # same as the wrapped hand
        self.limits = hand.limits
        self.begins = hand.begins  # type: ignore[misc]
        self.position_rate = hand.position_rate  # type: ignore[misc]
        self.position_resolution = hand.position_resolution  # type: ignore[misc]
        self._hand = hand
        self._clock = clock
        self._pacer = Pacer(hand.limits, silence)
        self._change = threading.Condition()
        self._thread: threading.Thread | None = None
        self._closed = False
        self._failure: HandError | None = None
        self._release_requested = False  # set by a signal handler
        self._leaving = Leaving(self._let_go)
        # The process of a separate hand and the source of a hand do not block.
        is_bounded = isinstance(hand, SeparateHand) or hand.of_source is not None
        self._driver = None if is_bounded else DriverThread()

    @property
    def counts(self) -> HandCounts:
        """Numbers of commands that were sent, clipped, superseded and repeated, and of releases."""
        return self._pacer.counts

    @property
    def failure(self) -> HandError | None:
        """Error because of which the hand accepts no commands; None without an error."""
        return self._failure

    @property
    def silenced(self) -> bool:
        """True if the hand was opened because the program was silent. :meth:`release` resets it."""
        with self._change:
            self._do_due_action()
            return self._pacer.silenced

    @property
    def wait(self) -> float:
        """Time from now until a command that you send now would reach the hand, s."""
        return self._pacer.wait(self._clock())

    def send(self, command: Command) -> None:
        """Send a command as soon as the hand accepts one. It replaces a command that still waits.

        If speed or force is not finite, the hand is released and HandError raised. It is also
        raised if the hand was released by a silence: call :meth:`release` before you go on.
        """
        self._leaving.rearm()
        with self._change:
            self._check_silence()
            try:
                self._pacer.offer(command, self._clock())
            except ValueError as error:
                self._release()
                raise HandError(f"{error}; the hand was released") from error
            self._do_due_action()
            self._change.notify()
            self._check()

    def start(self) -> None:
        """Begin the next closing now, for a hand that closes by itself."""
        with self._change:
            self._check_silence()
        self._do(self._hand.start)

    def alive(self) -> None:
        """Tell the watchdog that the program runs, and that the last command still applies."""
        self._leaving.rearm()
        with self._change:
            self._check()
            self._do_due_action()  # judges the silence, which this call ends
            self._pacer.alive(self._clock())

    def closing_speed(self, sample_time: float, host_time: float) -> ClosingSpeed | None:
        """Return the closing speed before a contact, as :meth:`Hand.closing_speed` does."""
        hand = self._hand
        if type(hand).closing_speed is Hand.closing_speed:
            return super().closing_speed(sample_time, host_time)
        measured: list[ClosingSpeed | None] = []

        def measure() -> None:
            from firstcontact.core import ClosingSpeed  # it needs NumPy, which no help waits for

            speed: object = hand.closing_speed(sample_time, host_time)
            if not isinstance(speed, ClosingSpeed | None):
                raise HandError(
                    f"closing_speed() of the hand {hand.name!r} must return a ClosingSpeed or "
                    f"None, not {type(speed).__name__}"
                )
            measured.append(speed)

        self._read(measure)
        return measured[0]

    def positions_since(self, since: float, host_zero: float) -> Sequence[tuple[float, ...]]:
        """Return the positions after ``since``, as :meth:`Hand.positions_since` does."""
        reports: list[tuple[float, ...]] = []
        hand = self._hand
        self._read(
            lambda: reports.extend(check_positions(hand, hand.positions_since(since, host_zero)))
        )
        return reports

    def release(self) -> None:
        """Open the hand now, and keep it open until the next command."""
        with self._change:
            if not self._closed:
                self._release()

    def close(self) -> None:
        """Release the hand, then close its connection. You may call this method twice."""
        # A second signal must not interrupt the release that the first one started.
        with self._leaving.deferred():
            with self._change:
                if self._closed:
                    return
                self._closed = True
                self._pacer.release()
                self._change.notify()
            atexit.unregister(self.close)
            try:
                if self._thread is not None:
                    self._thread.join()
            finally:
                released = self._attempt(self._let_go_and_close, ENDED)
                if self._driver is not None:
                    self._driver.end()
            if not released:
                raise HandError(
                    f"the hand {self.name!r} may still hold its object ({self._failure}): "
                    "look at the hand, and open it yourself"
                )

    def __enter__(self) -> Self:
        if self._closed or self._thread is not None:
            raise HandError(f"the hand {self.name!r} can be opened only once: make a new one")
        # A program with its own signal handlers leaves its ``with`` blocks by itself.
        self._leaving.install()
        try:
            self._hand.__enter__()
            atexit.register(self.close)
            thread = threading.Thread(target=self._watch, name="hand watchdog", daemon=True)
            thread.start()
            self._thread = thread
        except BaseException:  # a signal too: no ``with`` block closes the hand yet
            self.close()
            raise
        _log.info("hand %s is open", self.name)
        return self

    def _let_go_and_close(self) -> None:
        try:
            if self._thread is not None:
                self._hand.release()
        finally:
            self._hand.close()

    def _let_go(self) -> None:
        """Wake the watchdog thread to open the hand now. Signal handlers call this method."""
        self._release_requested = True
        if self._change.acquire(timeout=PROMPT):
            self._change.notify()
            self._change.release()

    def _check(self) -> None:
        if self._closed or self._thread is None:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        if self._failure is not None:
            raise HandError(
                f"the hand {self.name!r} failed ({self._failure}): check its connection, and open "
                "it again"
            ) from self._failure

    def _check_silence(self) -> None:
        self._check()
        self._do_due_action()
        self._check()
        if self._pacer.silenced:
            raise HandError(
                f"the hand {self.name!r} was released, because the program was silent: call "
                "release() before the next command"
            )

    def _do(self, act: Callable[[], None]) -> None:
        """Call ``act``, which uses a method of the hand. If this fails, open the hand and raise."""
        with self._change:
            self._check()
            if not self._attempt(act):
                self._release()
                self._check()

    def _read(self, read: Callable[[], None]) -> None:
        """Call ``read``, which reads from the hand. Other methods may run at the same time.

        If this fails, open the hand and raise HandError.
        """
        if self._driver is None:
            self._do(read)
            return
        self._check()
        if (error := call_directly(read)) is not None:
            self._do(partial(_fail, error))

    def _release(self) -> None:
        self._pacer.release()
        self._open_hand()

    def _open_hand(self) -> None:
        """Open the hand. If this fails, the watchdog thread retries."""
        if not self._attempt(self._hand.release, RELEASED):
            self._pacer.retry_release(self._clock())
            self._change.notify()

    def _attempt(self, act: Callable[[], None], seconds: float = STUCK) -> bool:
        """Call ``act``, which uses a method of the hand. Return True if it succeeded.

        Otherwise store its error as the hand's failure, and return False. A call that has not
        returned after ``seconds`` s counts as failed.
        """
        call = call_directly if self._driver is None else self._driver.call
        error = call(act, seconds)
        if error is None:
            return True
        if not isinstance(error, HandError):
            error = HandError(f"the hand's code raised {summarize_error(error)}")
        self._failure = error
        _log.info("hand %s failed: %s", self.name, error)
        return False

    def _do_due_action(self) -> None:
        """Send a command or open the hand, if one of these is due now."""
        if self._release_requested:
            self._release_requested = False
            self._release()
        due = self._pacer.due(self._clock())
        if due is None:
            return
        if due.command is None:
            _log.info("hand %s is released, because the program was silent", self.name)
            self._open_hand()
        elif not self._attempt(partial(self._hand.send, due.command)):
            self._release()

    def _watch(self) -> None:
        with self._change:
            while not self._closed:
                self._do_due_action()
                longest = inf
                if isinstance(self._hand, SeparateHand) and self._failure is None:
                    longest = MUTE / 2
                    if not self._attempt(self._hand.check):
                        self._release()
                wait = min(self._pacer.next_time() - self._clock(), longest)
                self._change.wait(None if wait == inf else max(wait, 0.0))


def _fail(error: BaseException) -> None:
    raise error


class DriverThread:
    """Thread that calls functions one after another. A call that blocks delays only later calls."""

    def __init__(self) -> None:
        self._calls: SimpleQueue[tuple[Callable[[], None], Future[None]] | None] = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._newest: Future[None] | None = None

    def call(self, act: Callable[[], None], seconds: float = STUCK) -> BaseException | None:
        """Call ``act`` in the thread. Return the error that it raised, None without one.

        Return HandError if ``act`` has not ended after ``seconds`` s. It then continues to run. If
        an earlier call still blocks, return HandError without waiting, unless ``seconds`` is above
        ``RELEASED``. The thread calls ``act`` once the earlier call ends.
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
        """Stop the thread after the calls that are queued."""
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
    """Call ``act`` in this thread. Return the error that it raised, None without one.

    In the main thread, interrupts such as Ctrl-C are raised. The function replaces
    :meth:`DriverThread.call` for hands without such a thread. ``seconds`` has no effect.
    """
    try:
        act()
    except BaseException as error:
        is_main = threading.current_thread() is threading.main_thread()
        if is_main and not isinstance(error, Exception):  # such as Ctrl-C
            raise
        return error
    return None
