"""Hands for tests."""

import threading
from collections.abc import Callable
from math import inf
from typing import Protocol

import pytest

from firstcontact.core import Command
from firstcontact.grasp import Hand, HandError, HandLimits
from firstcontact.grasp.hand import Begins

#: Longest wait on a busy machine, s.
PATIENCE = 60.0


class Commanded(Protocol):
    """Interface of objects that take commands."""

    def send(self, command: Command) -> None: ...


def refused(hand: Commanded, command: Command) -> str:
    """Send the command until the hand refuses it, and return the error's text."""
    tick = threading.Event()
    for _ in range(int(PATIENCE / 0.02)):
        try:
            hand.send(command)
        except HandError as error:
            return str(error)
        tick.wait(0.02)
    pytest.fail("the hand refused no command")


class RecordingHand(Hand):
    """Hand that records its orders. Set ``error`` to make the hand fail."""

    name = "recording"
    begins = Begins.OTHERS

    def __init__(self, limits: HandLimits | None = None) -> None:
        self.limits = limits or HandLimits(speed=0.1, force=5.0, rate=1000.0, watchdog=inf)
        self.orders: list[Command | str] = []
        self.error: Exception | None = None
        self._change = threading.Condition()

    def _record(self, order: Command | str) -> None:
        with self._change:
            self.orders.append(order)
            self._change.notify_all()

    def wait(self, reached: Callable[[list[Command | str]], bool]) -> None:
        """Wait until the recorded orders meet a condition."""
        with self._change:
            assert self._change.wait_for(lambda: reached(self.orders), PATIENCE), self.orders

    def send(self, command: Command) -> None:
        if self.error is not None:
            raise self.error
        self._record(command)

    def start(self) -> None:
        if self.error is not None:
            raise self.error
        self._record("start")

    def release(self) -> None:
        self._record("release")

    def close(self) -> None:
        self._record("close")
