"""What a hand is to a policy."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from enum import Flag, auto
from typing import ClassVar, Self

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


class Begins(Flag):
    """Who begins the closings of a hand."""

    #: Its own controller, its wearer, or the twin: that it closes is heard.
    OTHERS = auto()
    #: Whoever has the hand open here: it stays open until it is told to close.
    US = auto()


class Hand(ABC):
    """A hand that takes commands. Opened by ``with``; released on every way out.

    A registered one is made from its port's name or None, or from the source that it is
    driven over; making it opens nothing.
    """

    #: Under which it is registered and reported.
    name: ClassVar[str]
    limits: HandLimits
    #: Whether it moves for real: then no recording drives it, nor a clock that runs faster.
    real: ClassVar[bool] = True
    #: The port under which it works without hardware, for tests and dry runs.
    simulated_port: ClassVar[str | None] = None
    #: Whether a process of its own drives it, which lets go when the program hangs or is no more.
    separate: ClassVar[bool] = False
    #: Who begins its closings; both where it only takes note.
    begins: ClassVar[Begins] = Begins.OTHERS
    #: Name of the source over which it is driven; it is then made from that source.
    of_source: ClassVar[str | None] = None

    @abstractmethod
    def send(self, command: Command) -> None:
        """Order; returns at once. The hand may answer later or not at all.

        Raises
        ------
        HandError
            Not open, closed, or known to be out of reach.
        """

    @abstractmethod
    def release(self) -> None:
        """Open and let go, whatever was ordered before, until the next command. Never raises."""

    @abstractmethod
    def close(self) -> None:
        """Release and let go of the connection. Closing twice is fine."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
