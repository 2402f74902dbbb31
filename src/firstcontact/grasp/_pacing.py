"""What a hand is told and when, without threads: limits, rate, repeats, silence."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

from firstcontact.core import Command
from firstcontact.grasp._hand import HandLimits


@dataclass(slots=True)
class HandCounts:
    """What became of the commands.

    Attributes
    ----------
    sent
        Commands that went to the hand for the first time.
    clipped
        Commands that asked for more than the hand can do.
    superseded
        Commands that a newer one, or a release, overtook while they waited.
    repeated
        Commands sent again to keep the hand's own watchdog quiet.
    released
        Releases, for whatever reason.
    """

    sent: int = 0
    clipped: int = 0
    superseded: int = 0
    repeated: int = 0
    released: int = 0


@dataclass(frozen=True, slots=True)
class Due:
    """What is to be done now: tell the hand this command, or release it where there is none."""

    command: Command | None


class Pacer:
    """Decides what a hand is told; the times come from outside.

    Parameters
    ----------
    limits
        Of the hand.
    silence
        Time without a word of the program after which the hand is released, s.
    """

    def __init__(self, limits: HandLimits, silence: float) -> None:
        self.limits = limits
        self.counts = HandCounts()
        self._silence = silence
        self._interval = 1 / limits.rate
        # Three chances within the hand's patience; not faster than it takes commands.
        self._repeat = max(limits.watchdog / 3, self._interval)
        self._waiting: Command | None = None
        self._last: Command | None = None
        self._told = -inf
        self._heard = -inf

    def offer(self, command: Command, now: float) -> None:
        """Take the newest command; one that still waits is overtaken.

        Raises
        ------
        ValueError
            Speed or force is not a finite number.
        """
        if not (isfinite(command.speed) and isfinite(command.force)):
            raise ValueError(f"a hand cannot close at {command.speed} m/s with {command.force} N")
        limits = self.limits
        clipped = Command(
            min(max(command.speed, -limits.speed), limits.speed),
            min(max(command.force, 0.0), limits.force),
        )
        self.counts.clipped += clipped != command
        self.counts.superseded += self._waiting is not None
        self._waiting = clipped
        self._heard = now

    def alive(self, now: float) -> None:
        """The program is there, and wants nothing new."""
        self._heard = now

    def release(self) -> None:
        """Forget what was ordered; the caller releases the hand."""
        self.counts.superseded += self._waiting is not None
        self.counts.released += 1
        self._waiting = self._last = None

    def wait(self, now: float) -> float:
        """How long a command that is offered now waits before it is due, s."""
        return max(self._told + self._interval - now, 0.0)

    def next_time(self) -> float:
        """When :meth:`due` will have something at the earliest; infinite if never."""
        if self._waiting is None and self._last is None:
            return inf
        after = self._interval if self._waiting is not None else self._repeat
        return min(self._told + after, self._heard + self._silence)

    def due(self, now: float) -> Due | None:
        """What is to be done at this time; None if nothing."""
        if now < self.next_time():
            return None
        if now >= self._heard + self._silence:
            self.release()
            return Due(None)
        if self._waiting is not None:
            self._last, self._waiting = self._waiting, None
            self.counts.sent += 1
        else:
            self.counts.repeated += 1
        self._told = now
        return Due(self._last)
