"""A hand in a process of its own, which lets go when the program hangs or is no more."""

from __future__ import annotations

import time
from collections import deque
from contextlib import suppress
from dataclasses import replace
from typing import Any, Self

from firstcontact.core import Child, Command, InputError
from firstcontact.grasp._hand import Hand, HandError
from firstcontact.grasp._separate_process import ENDED

#: Longest wait for the hand to be there, s.
START = 30.0
#: A process that has not answered for so long is taken for lost, s.
MUTE = 1.0


class SeparateHand(Hand):
    """Drives a hand from a process of its own; a hand itself.

    The process has the hand's port, and hears each order through a pipe. When the pipe has been
    silent for as long as the hand's own watchdog takes, or ``silence``, it releases the hand; when
    the pipe ends it releases the hand, closes it and ends. So the hand is released, too, when this
    program is killed or stopped, crashes, or runs foreign code that keeps Python's lock, which no
    thread of its own can help against.

    Parameters
    ----------
    kind
        A class of hands made from a port; the process imports it by its module's name.
    port
        For it.
    silence
        Longest time without an order, s; :class:`~firstcontact.grasp._safe.SafeHand` repeats the
        last one more often.

    Raises
    ------
    InputError
        What the class raises; on entering, also what it raises then.
    """

    def __init__(self, kind: type[Any], port: str | None = None, silence: float = 1.0) -> None:
        hand: Hand = kind(port)
        self.name = hand.name  # type: ignore[misc]  # as what it drives
        self.begins = hand.begins  # type: ignore[misc]
        self.limits = replace(hand.limits, watchdog=min(hand.limits.watchdog, silence))
        self._words = (kind.__module__, kind.__qualname__, str(self.limits.watchdog))
        self._port = () if port is None else (port,)
        self._child: Child | None = None
        self._unanswered: deque[float] = deque()  # when each of them was told

    def send(self, command: Command) -> None:
        """Order.

        Raises
        ------
        HandError
            It is not open, has failed, or its process does not answer.
        """
        if self._child is None:
            raise HandError(f"the hand {self.name!r} is not open")
        self._hear(self._child)
        try:
            self._tell(self._child, f"send {command.speed!r} {command.force!r}")
        except OSError as error:
            raise HandError(f"the process of the hand {self.name!r} takes no orders") from error

    def release(self) -> None:
        """Open and let go, until the next order."""
        if self._child is not None:
            with suppress(OSError):  # a process that has ended has released it
                self._tell(self._child, "release")

    def close(self) -> None:
        """Have it released and closed, and wait for that."""
        child, self._child = self._child, None
        if child is not None:
            child.end(ENDED)

    def __enter__(self) -> Self:
        child = Child("firstcontact.grasp._separate_process", *self._words, *self._port, wakes=True)
        try:
            word, _, rest = child.answer(START).partition(" ")
        except TimeoutError:
            word, rest = "", f"the hand {self.name!r} was not there within {START:g} s: check it"
        except OSError:
            word, rest = "", ""
        except BaseException:
            child.end(ENDED)
            raise
        if word != "ready":
            child.end(ENDED)
            raise InputError(rest or f"the process of the hand {self.name!r} did not start")
        self._unanswered.clear()
        self._child = child
        return self

    def _tell(self, child: Child, line: str) -> None:
        child.tell(line, 0.0)
        self._unanswered.append(time.monotonic())

    def _hear(self, child: Child) -> None:
        """Take its answers so far."""
        while True:
            try:
                word, _, why = child.answer(0.0).partition(" ")
            except TimeoutError:
                break
            except OSError as error:
                raise HandError(f"the process of the hand {self.name!r} has ended") from error
            self._unanswered.popleft()
            if word != "done":
                raise HandError(why)
        if self._unanswered and time.monotonic() - self._unanswered[0] > MUTE:
            raise HandError(f"the process of the hand {self.name!r} does not answer")
