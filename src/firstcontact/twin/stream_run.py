"""A pinch from rest to rest, that takes commands until the hand opens."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.command import Command
from firstcontact.twin.commanded import CALM
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.drive import Drive
from firstcontact.twin.mechanics import OUTLINES, OUTPUTS, follow, integrate
from firstcontact.twin.run import PinchRun


class StreamRun(PinchRun):
    """A :class:`PinchRun` that is at rest at first and can be commanded.

    Until the first order takes effect it is that run, to the byte. Then the object is put
    where the fingers would have met it at the drawn speed; the drives do what they
    are ordered, and from then on a finger touches when its skin gets to its face and
    the motor is as loud as it is fast.

    Parameters
    ----------
    draw
        The chance in it; a run uses it up.
    duration
        The longest that the run can take, s, without ``lead``.
    lead
        Samples before the instant that the draw's timing counts from.
    drive
        What the commands go through.

    Attributes
    ----------
    released
        Whether it was told to open.
    """

    def __init__(self, draw: PinchDraw, duration: float, lead: int, drive: Drive) -> None:
        super().__init__(draw, duration, lead, at_rest=True)
        self.released = False
        self._drive = drive
        self._orders: list[tuple[int, Command | None]] = []
        self._placed = False
        self._told: Command | None = None
        # Reference speed when the command took effect that holds now, and its sample.
        self._from = 0.0
        self._since_order = 0
        self._met = np.full(2, np.nan)

    @property
    def commanded(self) -> bool:
        """Whether its speed is a command's, and not :attr:`speed`."""
        return self._told is not None

    def tell(self, order: Command | None, effect: int) -> None:
        """Order, or release by None; takes effect after the sample of number ``effect``.

        Commands are clipped by the drive before, and come in the order of their effects.
        One that should have had its effect already has it after the newest sample.
        """
        self._orders.append((max(effect, self.done - 1), order))

    def take_back(self) -> int:
        """No order holds from here on, none that waits either: how many commands waited."""
        waiting = sum(order is not None for _, order in self._orders)
        self._orders.clear()
        self._stand_in(self.done - 1)
        return waiting

    def advance(self, samples: int) -> NDArray[np.float64]:
        """Take the next samples, as :meth:`PinchRun.advance` does."""
        if not self._placed and not self._orders:
            return super().advance(samples)
        end = self.done + samples
        if samples < 1 or end > self.times.size:
            raise ValueError(f"{samples} samples asked of a run that has {self.times.size} in all")
        pieces = []
        while self.done < end:
            begin = max(self.done - 1, 0)
            while self._orders and self._orders[0][0] <= begin:
                self._obey(self._orders.pop(0)[1], begin)
            stop = min(end, self._orders[0][0] + 1) if self._orders else end
            pieces.append(self._follow(stop) if self._placed else super().advance(stop - self.done))
        return np.concatenate(pieces)

    def _follow(self, stop: int) -> NDArray[np.float64]:
        begin = max(self.done - 1, 0)
        times = self.times[begin:stop]
        out = np.empty((times.size, 2, OUTPUTS))
        drive = np.empty((max(times.size - 1, 1), 4))
        index, thumb = self._drawn
        shares = np.array([index.speed, thumb.speed]) / self.nominal_speed
        drive[:, :2] = self._references(begin, len(drive))[:, np.newaxis] * shares
        drive[:, 2:] = self._drive.force if self._told is None else self._told.force
        follow(
            index, thumb, self._held, self._touch, times, self._noise, self._noise_dt,
            self._substeps, drive, self._drive.back_damping, self.nominal_speed, math.inf, CALM,
            self._state, self._gap, self._met, out, np.empty((times.size, OUTLINES)),
        )  # fmt: skip
        fresh = out[self.done - begin :]
        self.done = stop
        return fresh

    @property
    def touched(self) -> tuple[bool, bool]:
        """Whether index and thumb have touched yet."""
        if not self._placed:
            return super().touched
        return not math.isnan(self._met[0]), not math.isnan(self._met[1])

    def _obey(self, order: Command | None, at: int) -> None:
        if not self._placed:
            self._met[list(self.touched)] = self.now
            speed = self._speed
            self._place()
            self._set_speed(speed)
            self._placed = True
        self._stand_in(at)
        self._told = order
        self.released = self.released or order is None

    def _stand_in(self, at: int) -> None:
        """Let :attr:`speed` be the reference of the command that has held until that sample."""
        if self._told is not None:
            self._set_speed(float(self._references(at - 1, 1)[0]))
        self._from, self._since_order = self._speed, at
        self._told = None

    def _references(self, begin: int, intervals: int) -> NDArray[np.float64]:
        """Mean reference speed of so many intervals from that sample on, m/s."""
        if self._told is None:
            return np.full(intervals, self._speed)
        counted = np.arange(1, intervals + 1) + (begin - self._since_order)
        return self._drive.references(self._from, self._told.speed, counted)

    def _place(self) -> None:
        """Fix where the object is by letting the hand close at the drawn speed, aside."""
        if not all(self.touched):
            self.speed = self.nominal_speed
            begin = max(self.done - 1, 0)
            stop = int(np.searchsorted(self.times, self._touch.max())) + 1
            times = self.times[begin:stop]
            integrate(
                *self._fingers, self._held, self._touch, times, self._noise, self._noise_dt,
                self._substeps, self._state.copy(), self._gap, np.empty((times.size, 2, OUTPUTS)),
            )  # fmt: skip
        self._touch = np.full(2, math.inf)
