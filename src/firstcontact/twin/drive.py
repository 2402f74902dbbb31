"""Drive of a finger: limits, speed control and position sensor."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, ClosingSpeed, Command
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.signal import closing_speed
from firstcontact.twin.mechanics import DRIVE_SPEED

#: Default time from a command to its effect, s.
LATENCY = 0.020


@dataclass(frozen=True, slots=True)
class Drive:
    """Limits and latency of a finger's drive."""

    latency: float = LATENCY
    """Time from a command to its effect, s, rounded to whole samples. The most important number:
    the study varies it from 0 to 80 ms."""
    acceleration: float = 10.0
    """Largest change of the commanded speed, m/s²: needs 4.5 N."""
    force: float = 12.0
    """Largest commanded force of a motor at its fingertip, N, as ``drive_force``. Braking and
    opening may always use it."""
    speed: float = 0.25
    """Largest commanded speed in either direction, m/s: twice the nominal closing speed."""
    back_damping: float = 60.0
    """Damping of a drive that the grip force pushes back, N s/m: 0.9 of critical damping."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            positive = value > 0 or (value == 0 and field.name in ("latency", "back_damping"))
            if not (math.isfinite(value) and positive):
                raise ArgumentError(f"the drive's {field.name} is {value}: use a positive number")

    @property
    def delay(self) -> int:
        """Number of samples from a command until it takes effect."""
        return round(self.latency * FINGERTIP_RATE)

    def clipped(self, command: Command) -> Command:
        if math.isnan(command.speed) or math.isnan(command.force):
            raise ArgumentError(f"{command} is not a command: use numbers for speed and force")
        return Command(
            min(max(command.speed, -self.speed), self.speed),
            min(max(command.force, 0.0), self.force),
        )


class DriveReference:
    """Speed that both drives aim at. It is constant, or changes towards a commanded speed."""

    def __init__(self, drive: Drive, speed: float) -> None:
        self._drive = drive
        self._begin = self._end = speed
        self._since = 0
        self.command: Command | None = None

    @property
    def force(self) -> float:
        """Largest force of each motor, N."""
        return self._drive.force if self.command is None else self.command.force

    def speed(self, sample: int) -> float:
        """Return the speed that the drives aim at in the interval that ends at ``sample``, m/s."""
        return float(self.speeds(sample - 1, 1)[0])

    def speeds(self, sample: int, intervals: int) -> NDArray[np.float64]:
        """Return the speeds that the drives aim at in the next ``intervals`` samples, m/s."""
        change = self._end - self._begin
        elapsed = sample - self._since
        rate = self._drive.acceleration / FINGERTIP_RATE
        if change == 0 or rate * (elapsed + 1) >= abs(change):
            return np.full(intervals, self._end)
        ramp = rate * np.arange(elapsed + 1, elapsed + intervals + 1)
        ramp_speeds = self._begin + math.copysign(1.0, change) * ramp
        return np.where(ramp < abs(change), ramp_speeds, self._end)

    def hold(self, speed: float) -> None:
        self._begin = self._end = speed
        self.command = None

    def obey(self, command: Command, sample: int) -> None:
        """Begin to change towards the commanded speed at the sample number ``sample``."""
        self._begin, self._end = self.speed(sample), command.speed
        self._since, self.command = sample, command


#: Samples between two positions: about 200 Hz.
EVERY = 25
#: Standard deviation of a position at the fingertip, m: 0.06 degrees of a finger of 0.1 m.
NOISE = 1e-4
#: Number of past positions that are kept in memory: those of 10 s. The twin may run many times
#: faster than real time.
REMEMBERED = 2000


class Positions:
    """Position sensor of the drives. It measures the mean travel of both fingertips with noise."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._travel = 0.0
        self._samples: deque[tuple[int, float]] = deque(maxlen=REMEMBERED)

    def add(self, motion: NDArray[np.float64], first_sample: int) -> None:
        travel = self._travel + np.cumsum(motion[..., DRIVE_SPEED].mean(axis=1)) / FINGERTIP_RATE
        for place in range(EVERY - 1, len(travel), EVERY):
            position = float(travel[place]) + NOISE * float(self._rng.standard_normal())
            self._samples.append((first_sample + place, position))
        self._travel = float(travel[-1])

    def zero(self) -> None:
        """Set the zero of the travel to the current position."""
        self._travel = 0.0

    def speed(self, sample: int) -> ClosingSpeed | None:
        """Return the closing speed before a contact at the sample ``sample``; None if unknown."""
        if not self._samples:
            return None
        samples, positions = zip(*self._samples, strict=True)
        return closing_speed(np.array(samples) / FINGERTIP_RATE, positions, sample / FINGERTIP_RATE)

    def since(self, time: float) -> list[tuple[float, float]]:
        """Return the positions measured after ``time``, s, as pairs (time, position).

        Times are in s on the clock of the samples, positions in m.
        """
        timed = ((sample / FINGERTIP_RATE, position) for sample, position in self._samples)
        return [(at, position) for at, position in timed if at > time]
