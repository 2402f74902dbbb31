"""The hand's drive: how late, how hard and how fast it does what it is told."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, Command, InputError

#: From a command to its effect unless something else is asked for, s.
LATENCY = 0.020


@dataclass(frozen=True, slots=True)
class Drive:
    """Where each number comes from is in ``docs/reference/twin-parameters.md``.

    A drive is a speed loop (:class:`firstcontact.twin._parameters.FingerParameters`)
    that follows a reference. When it is stalled it pushes with ``speed_gain`` times
    the commanded speed, or with the commanded force where that is less: a slow
    command is a gentle one, and a stop lets go of what was squeezed.

    Parameters
    ----------
    latency
        From a command to its effect, s: the brake latency. Whole samples.
    acceleration
        Of the reference, m/s^2.
    force
        The most that a motor pushes with at its fingertip, N; braking and opening may
        always use it.
    speed
        The fastest reference, m/s, closing or opening.
    back_damping
        Of a drive that the grip pushes back while it should close or stand, N s/m.

    Raises
    ------
    InputError
        A negative or infinite number.
    """

    latency: float = LATENCY
    acceleration: float = 10.0
    force: float = 12.0
    speed: float = 0.25
    back_damping: float = 60.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            positive = value > 0 or (value == 0 and field.name in ("latency", "back_damping"))
            if not (math.isfinite(value) and positive):
                raise InputError(f"the drive's {field.name} is {value}: use a positive number")

    @property
    def delay(self) -> int:
        """Samples from a command to its effect."""
        return round(self.latency * FINGERTIP_RATE)

    def clipped(self, command: Command) -> Command:
        """What it will do of a command.

        Raises
        ------
        InputError
            A speed or force that is no number.
        """
        if math.isnan(command.speed) or math.isnan(command.force):
            raise InputError(f"{command} cannot be done: its speed and force must be numbers")
        return Command(
            min(max(command.speed, -self.speed), self.speed),
            min(max(command.force, 0.0), self.force),
        )


class DriveReference:
    """What the drives follow: a steady speed, or the way from one commanded speed to another.

    Parameters
    ----------
    drive
        What commands go through.
    speed
        The steady speed at first, m/s.

    Attributes
    ----------
    command
        The command that holds; None for a steady speed.
    """

    def __init__(self, drive: Drive, speed: float) -> None:
        self._drive = drive
        self._begin = self._end = speed
        self._since = 0
        self.command: Command | None = None

    @property
    def force(self) -> float:
        """The most that either motor may press with, N."""
        return self._drive.force if self.command is None else self.command.force

    def at(self, sample: int) -> float:
        """Speed in the sampling interval that ends with that sample, m/s."""
        return float(self.after(sample - 1, 1)[0])

    def after(self, sample: int, intervals: int) -> NDArray[np.float64]:
        """Speed in each of so many sampling intervals from that sample on, m/s."""
        change = self._end - self._begin
        gone = sample - self._since
        rate = self._drive.acceleration / FINGERTIP_RATE
        if change == 0 or rate * (gone + 1) >= abs(change):
            return np.full(intervals, self._end)
        ramp = rate * np.arange(gone + 1, gone + intervals + 1)
        way = self._begin + math.copysign(1.0, change) * ramp
        return np.where(ramp < abs(change), way, self._end)

    def hold(self, speed: float) -> None:
        """Be steady at a speed."""
        self._begin = self._end = speed
        self.command = None

    def obey(self, command: Command, sample: int) -> None:
        """Be on the way to the commanded speed from that sample on."""
        self._begin, self._end = self.at(sample), command.speed
        self._since, self.command = sample, command
