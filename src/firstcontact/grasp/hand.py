"""What a hand is to a policy."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType
from typing import Protocol, Self

from firstcontact.core import Command


class HandError(RuntimeError):
    """The hand cannot take the command: not open, closed, not reachable, or the command is none."""


@dataclass(frozen=True, slots=True)
class HandLimits:
    """What a hand can do.

    Parameters
    ----------
    speed
        Highest closing speed at a fingertip, m/s.
    force
        Highest force of a fingertip, N.
    rate
        Most commands per second that it takes, Hz.
    watchdog
        Longest time without a command before it acts by itself, s; infinite
        where it waits for ever.
    """

    speed: float
    force: float
    rate: float
    watchdog: float


class Hand(Protocol):
    """A hand that takes commands. Opened by ``with``; released on every way out."""

    @property
    def name(self) -> str:
        """Under which it is registered and reported."""

    @property
    def limits(self) -> HandLimits:
        """What it can do."""

    def send(self, command: Command) -> None:
        """Order; returns at once. The hand may answer later or not at all.

        Raises
        ------
        HandError
            Not open, closed, or known to be out of reach.
        """

    def release(self) -> None:
        """Open and let go, whatever was ordered before, until the next command. Never raises."""

    def close(self) -> None:
        """Release and let go of the connection. Closing twice is fine."""

    def __enter__(self) -> Self: ...

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None: ...
