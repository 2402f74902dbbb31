"""Hands that tests command."""

from __future__ import annotations

import threading
from collections.abc import Callable
from math import inf
from typing import Protocol, Self

import pytest

from firstcontact.core import Command
from firstcontact.grasp import Begins, HandError, HandLimits

#: Of a machine that does much else at the same time, s.
PATIENCE = 60.0


class Commanded(Protocol):
    """Whatever takes commands."""

    def send(self, command: Command) -> None: ...


def refused(hand: Commanded, command: Command) -> str:
    """What it says when it takes no commands any more."""
    tick = threading.Event()
    for _ in range(int(PATIENCE / 0.02)):
        try:
            hand.send(command)
        except HandError as error:
            return str(error)
        tick.wait(0.02)
    pytest.fail("it took commands until the end")


class HeardHand:
    """Takes orders down; can be told to fail."""

    name = "heard"
    begins = Begins.OTHERS

    def __init__(self, limits: HandLimits | None = None) -> None:
        self.limits = limits or HandLimits(speed=0.1, force=5.0, rate=1000.0, watchdog=inf)
        self.told: list[Command | str] = []
        self.error: Exception | None = None
        self._change = threading.Condition()

    def _tell(self, what: Command | str) -> None:
        with self._change:
            self.told.append(what)
            self._change.notify_all()

    def wait(self, reached: Callable[[list[Command | str]], bool]) -> None:
        """Until what it was told is so."""
        with self._change:
            assert self._change.wait_for(lambda: reached(self.told), PATIENCE), self.told

    def send(self, command: Command) -> None:
        if self.error is not None:
            raise self.error
        self._tell(command)

    def release(self) -> None:
        self._tell("release")

    def close(self) -> None:
        self._tell("close")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
