"""Hand in a separate process, which releases the hand when the program hangs or ends."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, Self

from firstcontact.core import Child, Command, InputError
from firstcontact.grasp._hand import Hand, HandError
from firstcontact.grasp._separate_process import ENDED

#: Longest wait for the hand to open, s.
START = 30.0
#: Longest wait for positions, s: an estimate waits for them.
PROMPT = 0.002
#: Time without an answer after which the process counts as lost, s.
MUTE = 1.0


class SeparateHand(Hand):
    """Hand that a separate process drives. It is a hand itself."""

    def __init__(self, kind: type[Any], port: str | None = None, silence: float = 1.0) -> None:
        hand: Hand = kind(port)
        self.name = hand.name  # type: ignore[misc]  # same as the driven hand
        self.begins = hand.begins  # type: ignore[misc]
        self.limits = replace(hand.limits, watchdog=min(hand.limits.watchdog, silence))
        self._arguments = (kind.__module__, kind.__qualname__, str(self.limits.watchdog))
        self._port = () if port is None else (port,)
        self._child: Child | None = None
        self._unanswered: deque[float] = deque()  # time of each order without an answer

    def send(self, command: Command) -> None:
        """Send the command to the process."""
        if self._child is None:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        self._read_answers(self._child)
        try:
            self._write_order(self._child, f"send {command.speed!r} {command.force!r}")
        except OSError as error:
            raise HandError(f"the process of the hand {self.name!r} takes no orders") from error

    def positions(self) -> Sequence[tuple[float, float]]:
        """Return the positions that the hand last reported, or nothing if its process is late."""
        child = self._child
        if child is None:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        answer = ""
        try:
            self._write_order(child, "positions")
            until = time.monotonic() + PROMPT
            while self._unanswered:  # answers come in the order of the orders
                answer = self._read_answer(child, max(until - time.monotonic(), 0.0))
        except TimeoutError:
            return ()
        except OSError as error:
            raise HandError(f"the process of the hand {self.name!r} has ended") from error
        pairs = (pair.split(",") for pair in answer.split())
        return [(float(at), float(travel)) for at, travel in pairs]

    def release(self) -> None:
        """Open the hand, and keep it open until the next command."""
        if self._child is not None:
            with suppress(OSError):  # a process that has ended has released the hand
                self._write_order(self._child, "release")

    def close(self) -> None:
        """Release and close the hand, and wait until its process has ended."""
        child, self._child = self._child, None
        if child is not None:
            child.end(ENDED)

    def __enter__(self) -> Self:
        child = Child(
            "firstcontact.grasp._separate_process", *self._arguments, *self._port, wakes=True
        )
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
            raise InputError(message or f"the process of the hand {self.name!r} did not start")
        self._unanswered.clear()
        self._child = child
        return self

    def _write_order(self, child: Child, line: str) -> None:
        child.tell(line, 0.0)
        self._unanswered.append(time.monotonic())

    def _read_answers(self, child: Child) -> None:
        """Read all answers that have arrived."""
        while True:
            try:
                self._read_answer(child, 0.0)
            except TimeoutError:
                break
            except OSError as error:
                raise HandError(f"the process of the hand {self.name!r} has ended") from error
        if self._unanswered and time.monotonic() - self._unanswered[0] > MUTE:
            raise HandError(f"the process of the hand {self.name!r} does not answer")

    def _read_answer(self, child: Child, timeout: float) -> str:
        """Return the next answer without its first word, "done"."""
        word, _, detail = child.answer(timeout).partition(" ")
        self._unanswered.popleft()
        if word != "done":
            raise HandError(detail)
        return detail
