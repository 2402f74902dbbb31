"""Base class of hand drivers, with :class:`HandLimits` and :class:`HandError`."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Flag, auto
from math import isfinite
from typing import TYPE_CHECKING, ClassVar, Self

from firstcontact.core import Command

if TYPE_CHECKING:
    from firstcontact.core import ClosingSpeed


#: Largest distance of a fingertip from the zero of its positions, m.
FARTHEST = 10.0


class HandError(RuntimeError):
    """Error for a hand that is closed or unreachable, or for an invalid command."""


@dataclass(frozen=True, slots=True)
class HandLimits:
    """Limits of a hand's speed, force and rate of commands.

    Parameters
    ----------
    speed, force
        Highest closing speed of a fingertip, m/s, and highest grip force, N.
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
    """Origin of a hand's closings: this program, others, or others at this program's request."""

    #: The hand's controller, its wearer or the twin begins a closing. The signal shows when.
    OTHERS = auto()
    #: This program begins a closing. The hand stays open until then.
    US = auto()
    #: On request, a hand that closes by itself begins its next closing immediately
    #: (:meth:`Hand.start`).
    HURRY = auto()


class Hand(ABC):
    """Base class of drivers for prosthetic hands. Use a hand in a ``with`` block.

    The block connects to the hand, and always releases (opens) it at the end. :func:`open_hand`
    makes a hand with one argument: the name of its port (None for the default port), or the source
    that drives the hand. A new hand is not connected until the ``with`` block.
    """

    #: Name in the registry and in reports.
    name: ClassVar[str]
    limits: HandLimits
    #: True if the hand moves. Then recorded samples must not drive it.
    real: ClassVar[bool] = True
    #: Port that stands for a simulated hand, for tests and dry runs.
    simulated_port: ClassVar[str | None] = None
    #: True if a separate process drives the hand, and releases it when the program hangs or ends.
    #: It has no effect on a hand without a port, a class that cannot be imported, or one that
    #: overrides ``start``, ``closing_speed`` or ``positions_since``.
    separate: ClassVar[bool] = True
    #: Flags for who may begin a closing: the hand itself (or its wearer), or this program.
    begins: ClassVar[Begins] = Begins.OTHERS
    #: Name of the source of samples that also drives this hand; None for a hand with its own port.
    of_source: ClassVar[str | None] = None
    #: Rate at which recordings store the positions that the hand reports, Hz; 0 stores none.
    position_rate: ClassVar[float] = 0.0
    #: Resolution of the reported positions, m.
    position_resolution: ClassVar[float] = 1e-5

    @classmethod
    def needs_live_samples(cls, port: str | None) -> bool:
        """Return True if the hand at this port really moves, so that no replay may drive it."""
        return cls.real and (port is None or port != cls.simulated_port)

    @abstractmethod
    def send(self, command: Command) -> None:
        """Send a command without waiting for the hand's answer.

        Raise HandError if the hand is not open, or is known to be unreachable.
        """

    def start(self) -> None:
        """Begin the next closing immediately.

        Override this method for a hand that closes and opens by itself, but can also begin a
        closing on request (:attr:`Begins.HURRY`).
        """
        raise HandError(
            f"the hand {self.name!r} cannot close on request: wait for its next closing"
        )

    @abstractmethod
    def release(self) -> None:
        """Open the hand, and keep it open until the next command.

        Overrides must not raise errors.
        """

    def closing_speed(self, sample_time: float, host_time: float) -> ClosingSpeed | None:
        """Return the closing speed just before a contact, with its error; None if unknown.

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

        positions = self.positions_since(sample_time - 0.5, host_time - sample_time)
        if not positions:
            return None
        times, travel, *speeds = zip(*positions, strict=True)
        return closing_speed(times, travel, sample_time, speeds=speeds[0] if speeds else None)

    def positions(self) -> Sequence[tuple[float, ...]]:
        """Return the newest positions that the hand reported. They cover at least the last 0.5 s.

        Each is a pair: the time by ``time.monotonic()``, s, and the distance that the fingertip has
        moved, m. The zero and the direction of this distance do not matter. A hand that measures
        its speed adds it as a third number, in any unit.
        An estimate waits for this call, so return stored positions and send no request to the hand.
        Another thread may be in another method of the hand meanwhile.
        """
        return ()

    def positions_since(self, since: float, host_zero: float) -> Sequence[tuple[float, ...]]:
        """Return the positions after ``since``, with times on the clock of the samples, s.

        ``host_zero`` is the time of sample 0 by ``time.monotonic()``; NaN if unknown. Override
        this method for a hand whose positions have sample times.
        """
        positions = check_positions(self, self.positions())
        return [(at - host_zero, *rest) for at, *rest in positions if at - host_zero > since]

    @abstractmethod
    def close(self) -> None:
        """Open the hand, and close the connection. You may call this method twice."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def steady_clock() -> float:
    """Return the time of a monotonic clock, s, which also runs while the computer sleeps."""
    return time.clock_gettime(getattr(time, "CLOCK_BOOTTIME", time.CLOCK_MONOTONIC))


def check_positions(hand: Hand, reports: object) -> list[tuple[float, ...]]:
    """Return the positions ``reports`` of a hand in time order. Raise HandError if invalid."""
    try:
        pairs = [tuple(map(float, report)) for report in reports]  # type: ignore[attr-defined]
        is_valid = {len(pair) for pair in pairs} in (set(), {2}, {3})
        is_valid = is_valid and all(isfinite(p[0]) and abs(p[1]) <= FARTHEST for p in pairs)
    except (TypeError, ValueError, OverflowError):
        is_valid = False
    if not is_valid:
        raise HandError(
            f"positions() of the hand {hand.name!r} must return pairs (time, position) of numbers, "
            f"or triples with a speed: the time in s, and the position from -{FARTHEST:g} to "
            f"{FARTHEST:g} m"
        )
    return sorted(pairs)
