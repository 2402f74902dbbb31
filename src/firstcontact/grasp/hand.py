"""Base class of hands, with :class:`HandLimits` and :class:`HandError`."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Flag, auto
from typing import TYPE_CHECKING, ClassVar, Self

from firstcontact.core import Command

if TYPE_CHECKING:
    from firstcontact.core import ClosingSpeed


class HandError(RuntimeError):
    """Error for a hand that cannot take a command: not open, unreachable, or an invalid command."""


@dataclass(frozen=True, slots=True)
class HandLimits:
    """Limits of a hand.

    Parameters
    ----------
    speed, force
        Highest closing speed, m/s, and force, N, of a fingertip.
    rate
        Highest rate of commands, Hz.
    watchdog
        Time without a command after which the hand's own watchdog stops or opens the hand, s;
        infinite without a watchdog.
    """

    speed: float
    force: float
    rate: float
    watchdog: float


class Begins(Flag):
    """Parties that may begin the closings of a hand."""

    #: The hand's controller, its wearer or the twin begins a closing. The signal shows when.
    OTHERS = auto()
    #: This program begins a closing. The hand stays open until then.
    US = auto()
    #: On request, a hand that closes by itself begins its next closing immediately
    #: (:meth:`Hand.start`).
    HURRY = auto()


class Hand(ABC):
    """Base class of hands. Use one in a ``with`` block, which always releases it.

    The registry makes a hand from the name of its port (None for the default port), or from the
    source that drives the hand. A new hand has no connection until the ``with`` block begins.
    """

    #: Name in the registry and in reports.
    name: ClassVar[str]
    limits: HandLimits
    #: True if the hand moves: see :meth:`needs_live_samples`.
    real: ClassVar[bool] = True
    #: Port that stands for a simulated hand, for tests and dry runs.
    simulated_port: ClassVar[str | None] = None
    #: True if a separate process drives the hand, and releases it when the program hangs or ends.
    separate: ClassVar[bool] = False
    #: Parties that may begin the closings of this hand.
    begins: ClassVar[Begins] = Begins.OTHERS
    #: Name of the source whose simulated hand this is; None for a hand with a separate port.
    of_source: ClassVar[str | None] = None
    #: Rate, Hz, at which recordings keep the reported positions; 0 to keep none.
    position_rate: ClassVar[float] = 0.0
    #: Resolution of the reported positions, m.
    position_resolution: ClassVar[float] = 1e-5

    @classmethod
    def needs_live_samples(cls, port: str | None) -> bool:
        """Return True if only samples in real time may drive the hand, because it moves."""
        return cls.real and (port is None or port != cls.simulated_port)

    @abstractmethod
    def send(self, command: Command) -> None:
        """Send a command without waiting for the hand's answer.

        Raise HandError if the hand is not open, or is known to be unreachable.
        """

    def start(self) -> None:
        """Begin the next closing immediately.

        Override it for a hand that closes and opens by itself, but can begin a closing on request
        (:attr:`Begins.HURRY`).
        """
        raise HandError(f"the hand {self.name!r} begins no closing on request")

    @abstractmethod
    def release(self) -> None:
        """Open the hand, and keep it open until the next command. Raise no errors."""

    def closing_speed(self, sample_time: float, host_time: float) -> ClosingSpeed | None:
        """Return the closing speed just before a contact; None if it is not known.

        The base class computes it from :meth:`positions_since`.

        Parameters
        ----------
        sample_time
            Time of the contact on the clock of the samples, s: sample number divided by rate.
        host_time
            Time of the contact by ``time.monotonic()``, s. It is too late by the unknown smallest
            transport delay. NaN for samples that do not come in real time.
        """
        # Before the first contact, and not in the process of a separate hand, which needs no NumPy.
        from firstcontact.signal import closing_speed

        positions = self.positions_since(sample_time - 0.1, host_time - sample_time)
        if not positions:
            return None
        times, travel = zip(*positions, strict=True)
        return closing_speed(times, travel, sample_time)

    def positions(self) -> Sequence[tuple[float, float]]:
        """Return the newest positions that the hand reported. They cover at least the last 0.5 s.

        Each is a time by ``time.monotonic()``, s, and the distance that the fingertip has moved, m.
        The zero of this distance does not matter.
        An estimate waits for this call, so return stored positions and send no request to the hand.
        """
        return ()

    def positions_since(self, since: float, host_zero: float) -> Sequence[tuple[float, float]]:
        """Return the positions after ``since``, with times on the clock of the samples, s.

        ``host_zero`` is the time of sample 0 by ``time.monotonic()``; NaN if unknown. Override
        this method for a hand whose positions have sample times.
        """
        return [(at - host_zero, x) for at, x in self.positions() if at - host_zero > since]

    @abstractmethod
    def close(self) -> None:
        """Release the hand and close the connection. Closing twice is allowed."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
