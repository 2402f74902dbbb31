"""Schedule of the commands to a hand, which limits their rate and repeats the last one."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite

from firstcontact.core import ArgumentError, Command
from firstcontact.grasp.hand import HandLimits


@dataclass(slots=True)
class HandCounts:
    """Counts of the commands to a hand: sent, clipped, superseded, repeated; and of releases."""

    sent: int = 0
    clipped: int = 0
    superseded: int = 0
    repeated: int = 0
    released: int = 0


@dataclass(frozen=True, slots=True)
class Due:
    """Action that is due: send ``command``, or open the hand if ``command`` is None."""

    command: Command | None


class Pacer:
    """Schedule of a hand's commands. It has no clock: callers pass their time ``now``, s."""

    def __init__(self, limits: HandLimits, silence: float) -> None:
        if not silence > 0:  # true of NaN
            raise ArgumentError(
                f"the time without a command is {silence:g} s: use more than 0", parameter="silence"
            )
        self.limits = limits
        self.counts = HandCounts()
        #: True after a release because of silence, until the next call of :meth:`release`.
        self.silenced = False
        self._silence = silence
        self._interval = 1 / limits.rate
        # Repeat three times before the hand's watchdog acts, but no faster than the hand allows.
        self._repeat = max(limits.watchdog / 3, self._interval)
        self._waiting: Command | None = None
        self._last: Command | None = None
        self._sent_at = -inf
        self._called_at = -inf
        self._release_at = inf  # time at which a failed release is tried again

    def offer(self, command: Command, now: float) -> None:
        """Schedule a command. It replaces a command that still waits."""
        if not (isfinite(command.speed) and isfinite(command.force)):
            raise ValueError(
                f"a hand cannot close at {command.speed} m/s with {command.force} N: use finite "
                "numbers"
            )
        limits = self.limits
        clipped = Command(
            min(max(command.speed, -limits.speed), limits.speed),
            min(max(command.force, 0.0), limits.force),
        )
        self.counts.clipped += clipped != command
        self.counts.superseded += self._waiting is not None
        self._waiting = clipped
        self._called_at = now

    def alive(self, now: float) -> None:
        """Record at ``now`` that the program runs, although it has no new command."""
        self._called_at = now

    def release(self) -> None:
        self.counts.superseded += self._waiting is not None
        self.counts.released += 1
        self._waiting = self._last = None
        self._release_at = inf
        self.silenced = False

    def retry_release(self, now: float) -> None:
        """Schedule another release, because the last one failed."""
        self._release_at = now + self._silence

    def wait(self, now: float) -> float:
        """Return the time until a command that you offer at ``now`` would be sent, s."""
        return max(self._sent_at + self._interval - now, 0.0)

    def next_time(self) -> float:
        """Return the time of the next action, s, on the callers' clock; infinite without one."""
        if self._waiting is None and self._last is None:
            return self._release_at
        pause = self._interval if self._waiting is not None else self._repeat
        return min(self._sent_at + pause, self._called_at + self._silence)

    def due(self, now: float) -> Due | None:
        """Return the action to carry out at ``now``; None if there is none."""
        if now < self.next_time():
            return None
        # A hand whose own watchdog has acted must not close again by a repeated command.
        has_lapsed = self._last is not None and now > self._sent_at + self.limits.watchdog
        if has_lapsed or now >= min(self._called_at + self._silence, self._release_at):
            self.release()
            self.silenced = True
            return Due(None)
        if self._waiting is not None:
            self._last, self._waiting = self._waiting, None
            self.counts.sent += 1
        else:
            self.counts.repeated += 1
        self._sent_at = now
        return Due(self._last)
