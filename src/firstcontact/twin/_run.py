"""Simulation of one pinch in short pieces of time, so that commands can change its course."""

from __future__ import annotations

import copy
import math
from collections import deque
from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Command
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.drive import Drive, DriveReference
from firstcontact.twin.mechanics import (
    CONTACT_FORCE,
    FINGER_STATES,
    OUTPUTS,
    STATES,
    ObjectParameters,
    Piece,
    Timing,
    contact_arms,
    contact_stiffness,
    integrate_all,
)
from firstcontact.twin.noise import PhalanxNoise
from firstcontact.twin.objects import CRUSHED

#: Steps for each sample after the first contact, half as many before. A step is 25 us; halving it
#: changes the piezo's waveform by less than 0.15 %.
SUBSTEPS = 8
#: Time after both contacts from which a commanded hand takes half the steps, s: the remaining
#: motion is slow.
CALM = 0.03
#: Largest deviation of a sampling instant, s.
LARGEST_WOBBLE = 2e-5


class PinchRun:
    """Simulation of one pinch in progress, from its drawn parameters."""

    def __init__(
        self,
        draw: PinchDraw,
        duration: float,
        lead: int = 0,
        drive: Drive | None = None,
        *,
        at_rest: bool = False,
        damped: bool = False,
        substeps: int = SUBSTEPS,
    ) -> None:
        begin = lead / FINGERTIP_RATE
        nominal = np.arange(-lead, round(duration * FINGERTIP_RATE)) / FINGERTIP_RATE
        wobble = draw.jitter * draw.rng.standard_normal(nominal.size)
        wobble = np.clip(wobble, -LARGEST_WOBBLE, LARGEST_WOBBLE)
        self.times: NDArray[np.float64] = nominal + begin + wobble - wobble[0]
        length = duration + begin + 1e-3
        self._noise = PhalanxNoise(draw.noise, length, draw.rng, 0.0 if at_rest else 1.0)
        self._fingers = draw.fingers
        self._substeps = substeps
        self._speeds = np.array([p.speed for p in draw.fingers])
        self.nominal_speed = float(self._speeds.sum() / 2)
        self._state = np.zeros(STATES)
        if not at_rest:
            for f in range(2):
                self._state[f * FINGER_STATES + 1 : f * FINGER_STATES + 8 : 2] = self._speeds[f]
        self._touched = np.full(2, np.nan)
        speed = 0.0 if at_rest else self.nominal_speed
        # Until the object is placed, the contact times decide when a finger touches; after that
        # the positions of the object's faces do.
        self._approach = Approach(draw.timing, begin, self.nominal_speed, speed)
        self._placed = False
        # Position of the object if the first order takes effect after this sample. Copies share it.
        self._places: dict[int, NDArray[np.float64]] = {}
        self._gap = np.full(2, np.nan)
        self._set_object(draw.object)
        self._drive = Drive() if drive is None else drive
        self._damped = damped
        self._orders: deque[tuple[int, Command | None]] = deque()
        self._reference = DriveReference(self._drive, speed)
        self.done = 0
        self.released = False
        self.limit = math.inf
        self.broken_at: int | None = None

    def fork(self) -> Self:
        other = copy.copy(self)
        other._state = self._state.copy()
        other._touched = self._touched.copy()
        other._gap = self._gap.copy()
        other._approach = copy.copy(self._approach)
        other._reference = copy.copy(self._reference)
        other._orders = self._orders.copy()
        return other

    @property
    def now(self) -> float:
        return float(self.times[self.done - 1]) if self.done else 0.0

    @property
    def speed(self) -> float:
        """Closing speed that the drives aim at, m/s: mean of both fingers. Negative values open."""
        return self._reference.speed(self.done - 1)

    @speed.setter
    def speed(self, speed: float) -> None:
        old = self.speed
        if speed == old:
            return
        self._reference.hold(speed)
        if not self._placed:
            self._approach.turn(old, speed, self.now, ~np.isnan(self._gap))

    @property
    def loudness(self) -> float:
        """Loudness of the motor until the first order takes effect; 1 is its full strength."""
        return self._noise.loudness

    @loudness.setter
    def loudness(self, loudness: float) -> None:
        self._noise.loudness = loudness

    @property
    def commanded(self) -> bool:
        return self._reference.command is not None

    @property
    def drive_speed(self) -> float:
        """Mean speed at which both drives move now, m/s."""
        return float(self._state[1] + self._state[FINGER_STATES + 1]) / 2

    @property
    def touched(self) -> tuple[bool, bool]:
        """Two booleans, for index finger and thumb: True once the finger has touched the object."""
        index, thumb = self._touched if self._placed else self._gap
        return not math.isnan(index), not math.isnan(thumb)

    def order(self, command: Command | None, effect: int) -> None:
        """Queue an order that takes effect at the sample number ``effect``.

        The order is a command, or None to open the hand.
        """
        clipped = None if command is None else self._drive.clipped(command)
        self._orders.append((max(effect, self.done - 1), clipped))

    def withdraw(self) -> int:
        """Cancel all orders. The drives keep the speed that they aim at now.

        Return the number of commands that had not taken effect yet.
        """
        waiting = sum(command is not None for _, command in self._orders)
        self._orders.clear()
        self._reference.hold(self.speed)
        return waiting

    def advance(self, samples: int) -> NDArray[np.float64]:
        end = self.done + samples
        if samples < 1 or end > self.times.size:
            left = self.times.size - self.done
            raise ValueError(
                f"{samples} samples cannot be computed: ask for at least 1 of the {left} left"
            )
        pieces = []
        while self.done < end:
            # A piece starts at the newest sample, whose output exists already.
            begin = max(self.done - 1, 0)
            while self._orders and self._orders[0][0] <= begin:
                self._obey(self._orders.popleft()[1], begin)
            stop = min(end, self._orders[0][0] + 1) if self._orders else end
            piece = self._piece(begin, stop)
            pieces.append(self._keep(begin, piece, *integrate_all([piece])))
        return pieces[0] if len(pieces) == 1 else np.concatenate(pieces)

    @property
    def _strength(self) -> float:
        """Contact force that breaks the object, N; infinite once it is broken."""
        return self.limit if self.broken_at is None else math.inf

    def _piece(self, begin: int, stop: int) -> Piece:
        reference = self._reference.speeds(begin, max(stop - begin - 1, 1))[:, np.newaxis]
        if self._placed:
            speeds = reference * (self._speeds / self.nominal_speed)
        else:
            speeds = reference / self.nominal_speed * self._speeds
            self._noise.scale_until(self.times[stop - 1])
        return self._arguments(
            begin, stop, speeds, self._state, self._touched, self._strength,
            self._drive.back_damping if self._placed or self._damped else 0.0,
        )  # fmt: skip

    def _keep(self, begin: int, piece: Piece, taken: int) -> NDArray[np.float64]:
        out = piece.out[:taken]
        if max(out[-1, 0, CONTACT_FORCE], out[-1, 1, CONTACT_FORCE]) > self._strength:
            self.broken_at = begin + taken - 1
            self._set_object(self._held.stiffened(CRUSHED))
        fresh = out[self.done - begin :]
        self.done = begin + taken
        return fresh

    def _arguments(
        self, begin: int, stop: int, speeds: NDArray[np.float64], state: NDArray[np.float64],
        touched: NDArray[np.float64], limit: float, damping: float,
    ) -> Piece:  # fmt: skip
        return Piece(
            *self._fingers, self._relaxing, self._stiffness, self._approach.touch,
            self.times[begin:stop], self._noise.points, self._noise.dt,
            self._substeps, speeds, self._reference.force, damping,
            self.nominal_speed if self._placed else 0.0, limit,
            CALM if self._placed else math.inf, max(self._substeps // 2, 1),
            state, self._gap, touched, np.empty((stop - begin, 2, OUTPUTS)),
        )  # fmt: skip

    def _set_object(self, target: ObjectParameters) -> None:
        self._held = target
        self._relaxing = contact_arms(self._fingers[0], target)
        self._stiffness = np.array([contact_stiffness(p, target) for p in self._fingers])

    def _obey(self, command: Command | None, sample: int) -> None:
        if not self._placed:
            self._place(sample)
        if command is None:
            self._reference.hold(self._reference.speed(sample))
            self.released = True
        else:
            self._reference.obey(command, sample)

    def _place(self, begin: int) -> None:
        """Place the object so that each finger touches it at the drawn time.

        The places come from a simulation of the approach at the drawn speed, from the sample number
        ``begin`` on.
        """
        if not self._damped:
            # An undamped drive still oscillates, so the calm time begins only now.
            self._touched[~np.isnan(self._gap)] = self.now
        if begin in self._places:
            self._gap = self._places[begin].copy()
        elif np.isnan(self._gap).any():
            speed, self.speed = self.speed, self.nominal_speed
            stop = int(np.searchsorted(self.times, self._approach.touch.max())) + 1
            speeds = np.tile(self._speeds, (stop - begin, 1))
            piece = self._arguments(
                begin, stop, speeds, self._state.copy(), self._touched.copy(), math.inf, 0.0
            )
            integrate_all([piece])
            self._reference.hold(speed)
            self._places[begin] = self._gap.copy()
        self._approach.touch = np.full(2, math.inf)
        self._placed = True


def whole_motions(runs: Sequence[PinchRun]) -> list[NDArray[np.float64]]:
    """Simulate pinches from start to end. Return the motion of each, shape (samples, 2, OUTPUTS).

    No sample of these runs may have been simulated before.
    """
    pieces = [run._piece(0, run.times.size) for run in runs]
    taken = integrate_all(pieces)
    return [run._keep(0, piece, n) for run, piece, n in zip(runs, pieces, taken, strict=True)]


class Approach:
    """Predicted contact times of both fingers, s. Each finger has a fixed distance to travel."""

    def __init__(self, timing: Timing, begin: float, nominal: float, speed: float) -> None:
        first, second, first_is_index = timing
        drawn = np.array([first, second] if first_is_index else [second, first]) + begin
        self.touch: NDArray[np.float64] = drawn if speed == nominal else np.full(2, math.inf)
        self._distance_left = nominal * drawn
        self._since = 0.0

    def turn(self, old: float, new: float, now: float, touching: NDArray[np.bool_]) -> None:
        """Update the contact times after the closing speed changed from ``old`` to ``new``, m/s.

        ``now`` is the time of the change, s. Fingers for which ``touching`` is True keep their
        times.
        """
        self._distance_left -= old * (now - self._since)
        self._since = now
        contact_times = now + self._distance_left / new if new > 0 else math.inf
        self.touch = np.where(touching, self.touch, contact_times)
