"""Hand in a separate process, which releases the hand when the program hangs or ends.

The process imports no NumPy and computes nothing, so that it always answers in time.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from typing import Any, Self

from firstcontact.core import Command, DeviceError, InputError
from firstcontact.core.text import summarize_error
from firstcontact.grasp.hand import Hand, HandError, check_positions
from firstcontact.jobs import Child

#: Longest wait for the hand to open, s.
START = 30.0
#: Longest wait for positions, s: an estimate waits for them.
PROMPT = 0.002
#: Time without an answer after which the process counts as lost, s.
MUTE = 1.0
#: Longest time of a release, s: a driver may wait until the hand is open.
RELEASED = 3.0
#: Longest time from the end of the orders to the end of the process, s. The Ability Hand needs
#: 2 s of it to open.
ENDED = 5.0
#: Most positions in an answer, so that it fits into a pipe.
MOST_POSITIONS = 60
#: Methods that a hand in a separate process cannot override.
NOT_SENT = "start", "closing_speed", "positions_since"


def can_separate(kind: type[Hand]) -> bool:
    """Return True if another process can import this hand's class and call all its methods."""
    is_found = getattr(sys.modules.get(kind.__module__), kind.__qualname__, None) is kind
    plain = all(getattr(kind, name) is getattr(Hand, name) for name in NOT_SENT)
    return is_found and plain and kind.__module__ != "__main__"


class SeparateHand(Hand):
    """Hand whose driver runs in a separate process."""

    def __init__(self, kind: type[Any], port: str | None = None, silence: float = 1.0) -> None:
        hand: Hand = kind(port)
        self.name = hand.name  # type: ignore[misc]  # same as the driven hand
        self.begins = hand.begins  # type: ignore[misc]
        self.position_rate = hand.position_rate  # type: ignore[misc]
        self.position_resolution = hand.position_resolution  # type: ignore[misc]
        self.limits = replace(hand.limits, watchdog=min(hand.limits.watchdog, silence))
        self._arguments = [kind.__module__, kind.__qualname__, str(self.limits.watchdog)]
        self._arguments += [] if port is None else [port]
        self._child: Child | None = None
        self._unanswered: deque[float] = deque()  # latest time of the answer to each order

    @property
    def pid(self) -> int:
        """Process number of the hand's driver. The hand must be open."""
        return self._opened().pid

    def send(self, command: Command) -> None:
        child = self._opened()
        self._read_answers(child)
        try:
            self._write_order(child, f"send {command.speed!r} {command.force!r}")
        except OSError as error:
            raise self._failed("takes no commands") from error

    def positions(self) -> Sequence[tuple[float, ...]]:
        """Return the positions that the hand reported last; () if its process answers too late."""
        child, answer = self._opened(), ""
        try:
            self._write_order(child, "positions")
            until = time.monotonic() + PROMPT
            while self._unanswered:  # answers come in the order of the orders
                answer = self._read_answer(child, max(until - time.monotonic(), 0.0))
        except TimeoutError:
            return ()
        except OSError as error:
            raise self._failed("has ended") from error
        return [tuple(map(float, pair.split(","))) for pair in answer.split()]

    def release(self) -> None:
        if self._child is not None:
            with suppress(OSError):  # a process that has ended has released the hand
                self._write_order(self._child, "release", RELEASED)

    def check(self) -> None:
        """Raise HandError if the process has failed or does not answer."""
        self._read_answers(self._opened())

    def close(self) -> None:
        child, self._child = self._child, None
        if child is None:
            return
        child.end_input()
        reason, until = "", time.monotonic() + ENDED
        with suppress(OSError):  # the end of its answers, or a timeout
            while True:
                word, _, detail = child.answer(max(until - time.monotonic(), 0.0)).partition(" ")
                reason = reason if word == "done" else detail
        if time.monotonic() >= until:
            child.interrupt()
        if not child.end(MUTE) or reason:
            raise HandError(
                f"nothing confirms that the hand {self.name!r} is open "
                f"({reason or f'its process failed or did not end within {ENDED:g} s'}): look at "
                "the hand, and open it yourself"
            )

    def __enter__(self) -> Self:
        child = Child("firstcontact.grasp.separate", *self._arguments, wakes=True)
        try:
            word, _, message = child.answer(START).partition(" ")
        except TimeoutError:
            word, message = "", f"the hand {self.name!r} did not open within {START:g} s: check it"
        except OSError:
            word, message = "", ""
        except BaseException:
            child.end(ENDED)
            raise
        if word != "ready":
            child.end(ENDED)
            raise DeviceError(
                message
                or f"the process of the hand {self.name!r} did not start: see what it printed"
            )
        self._unanswered.clear()
        self._child = child
        return self

    def _failed(self, problem: str) -> HandError:
        return HandError(
            f"the process of the hand {self.name!r} {problem}: check the hand's connection, and "
            "open it again"
        )

    def _opened(self) -> Child:
        if self._child is None:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        return self._child

    def _write_order(self, child: Child, line: str, seconds: float = MUTE) -> None:
        child.tell(line, 0.0)
        # An order waits for those before it.
        self._unanswered.append(max([time.monotonic() + seconds, *self._unanswered]))

    def _read_answers(self, child: Child) -> None:
        try:
            while True:
                self._read_answer(child, 0.0)
        except TimeoutError:
            if self._unanswered and time.monotonic() > self._unanswered[0]:
                child.interrupt()  # a driver that Python can interrupt then opens the hand
                raise self._failed("does not answer") from None
        except OSError as error:
            raise self._failed("has ended") from error

    def _read_answer(self, child: Child, timeout: float) -> str:
        """Return the next answer of the process, without its first word "done".

        Raise HandError if the answer is an error, or if there is none after ``timeout`` s.
        """
        word, _, detail = child.answer(timeout).partition(" ")
        self._unanswered.popleft()
        if word != "done":
            raise HandError(detail)
        return detail


def _serve(hand: Hand, silence: float, out: int) -> None:
    """Carry out the orders for a hand that arrive on standard input, until the input ends.

    Write one answer per order to the file descriptor ``out``. Release the hand after ``silence`` s
    without an order.
    """
    part = b""
    while True:
        if not select.select([0], [], [], silence)[0]:
            hand.release()
            continue
        data = os.read(0, 4096)
        if not data:
            return
        *lines, part = (part + data).split(b"\n")
        for line in lines:
            _write_line(out, _obey(hand, line.decode().split()))


def _obey(hand: Hand, words: list[str]) -> str:
    try:
        match words:
            case ["send", speed, force]:
                hand.send(Command(float(speed), float(force)))
            case ["positions"]:
                latest = check_positions(hand, hand.positions())[-MOST_POSITIONS:]
                return " ".join(["done", *(",".join(map(repr, report)) for report in latest)])
            case _:
                hand.release()
    except HandError as error:
        return f"failed {error}"
    except Exception as error:
        return f"failed it raised {summarize_error(error)}"
    return "done"


def _write_line(out: int, line: str) -> None:
    with suppress(OSError):  # the program has ended
        os.write(out, line.replace("\n", " ").encode() + b"\n")


def _end_within(seconds: float) -> None:
    signal.setitimer(signal.ITIMER_REAL, seconds)


def _main() -> None:
    parent = os.getppid()
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    # SIGCONT arrives when the program ends. The timer ends this process even if a call blocks it.
    signal.signal(signal.SIGCONT, lambda *_: None if os.getppid() == parent else _end_within(ENDED))
    # Output that the hand's package prints must not enter the pipe.
    out = os.dup(1)
    os.dup2(2, 1)
    module, name, silence, *port = sys.argv[1:]
    try:
        hand: Hand = getattr(import_module(module), name)(port[0] if port else None)
        try:
            hand.__enter__()
            _write_line(out, "ready")
            _serve(hand, float(silence), out)
            _end_within(ENDED)
        finally:
            hand.close()
    except (InputError, HandError) as error:
        _write_line(out, f"refused {error}")
        sys.exit(1)
    except Exception as error:
        _write_line(out, f"refused the hand {name} raised {summarize_error(error)}")
        sys.exit(1)


if __name__ == "__main__":
    _main()
