"""The hand's drive: how late, how hard and how fast it does what it is told."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.command import Command
from firstcontact.core.errors import InputError
from firstcontact.core.layout import FINGERTIP_RATE

#: From a command to its effect unless something else is asked for, s.
LATENCY = 0.020


@dataclass(frozen=True, slots=True)
class Drive:
    """Where each number comes from is in ``docs/reference/twin-parameters.md``.

    A drive is a speed loop (:class:`firstcontact.twin.parameters.FingerParameters`)
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

    def references(
        self, begin: float, target: float, intervals: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Reference speed on the way from one commanded speed to another.

        Parameters
        ----------
        begin
            The reference before, m/s.
        target
            The commanded speed, m/s.
        intervals
            Which sampling intervals, counted from 1 where the command takes effect.

        Returns
        -------
        ndarray
            m/s, of the shape of ``intervals``.
        """
        ramp = self.acceleration / FINGERTIP_RATE * intervals
        change = target - begin
        return np.where(ramp < abs(change), begin + math.copysign(1.0, change) * ramp, target)
