"""A pinch that is advanced piece by piece, and can be commanded while it runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.mechanics import FINGER_STATES, OUTPUTS, STATES, integrate
from firstcontact.twin.noise import OVERSAMPLING, phalanx_force

#: Steps per sampling interval after the first contact, half as many before: 20 us
#: each, where halving them moves the piezo's waveform by less than 0.1 %.
SUBSTEPS = 10
#: Sampling instants are off by no more than this, s: a tenth of the interval or
#: more would be another fault than jitter.
LARGEST_WOBBLE = 2e-5


@dataclass(frozen=True, slots=True, eq=False)
class Course:
    """What a run meets whatever its drives do.

    Parameters
    ----------
    times
        Sampling instants of the longest run, s from its start, shape (samples,).
    noise
        Force on each phalanx, N, shape (2, points).
    noise_dt
        Between two points, s.
    touch
        When index and thumb touch if nothing else is commanded, s, shape (2,).
    """

    times: NDArray[np.float64]
    noise: NDArray[np.float64]
    noise_dt: float
    touch: NDArray[np.float64]


def drawn_course(draw: PinchDraw, duration: float, lead: int) -> Course:
    """The course of a run; uses up some of the draw's chance.

    Parameters
    ----------
    draw
        The pinch.
    duration
        The longest that the run can take, s, without ``lead``.
    lead
        Samples before the instant that the draw's timing counts from.
    """
    before = lead / FINGERTIP_RATE
    nominal = np.arange(-lead, round(duration * FINGERTIP_RATE)) / FINGERTIP_RATE
    wobble = draw.jitter * draw.rng.standard_normal(nominal.size)
    wobble = np.clip(wobble, -LARGEST_WOBBLE, LARGEST_WOBBLE)
    rate = OVERSAMPLING * FINGERTIP_RATE
    length = duration + before + 1e-3
    noise = np.stack([phalanx_force(n, length, rate, draw.rng) for n in draw.noise])
    first, second, first_is_index = draw.timing
    touch = np.array([first, second] if first_is_index else [second, first]) + before
    return Course(nominal + before + wobble - wobble[0], noise, 1 / rate, touch)


def moving(draw: PinchDraw) -> NDArray[np.float64]:
    """State of a hand that closes at its drawn speed, before any vibration."""
    state = np.zeros(STATES)
    for f, p in enumerate(draw.fingers):
        state[f * FINGER_STATES + 1 : f * FINGER_STATES + 8 : 2] = p.speed
    return state


class PinchRun:
    """One drawn pinch on its way.

    A finger touches when it has travelled as far as it would have by its drawn
    instant at the drawn speed; at that speed all along, it touches at that instant.
    How a run is cut into pieces changes nothing, as long as its loudness stays.

    Parameters
    ----------
    draw
        The chance in it; a run uses it up.
    duration
        The longest that the run can take, s, without ``lead``.
    lead
        Samples before the instant that the draw's timing counts from.
    at_rest
        Whether the run begins with fingers and motor at rest, and not at the
        drawn speed with the motor's noise at its full strength.
    substeps
        Steps per sampling interval once a finger has touched.

    Attributes
    ----------
    times
        Sampling instants of the longest run, s from its start, shape (samples,).
    done
        Samples that have been taken.
    nominal_speed
        Closing speed of the hand as drawn, the mean of both fingers, m/s.
    loudness
        Of the motor's noise, as a share of its full strength; may be set, and is
        reached evenly by the end of the next piece.
    """

    def __init__(
        self,
        draw: PinchDraw,
        duration: float,
        lead: int = 0,
        *,
        at_rest: bool = False,
        substeps: int = SUBSTEPS,
    ) -> None:
        course = drawn_course(draw, duration, lead)
        self.times: NDArray[np.float64] = course.times
        self.done = 0
        self._noise = course.noise
        self._noise_dt = course.noise_dt
        self._shaped = 0  # points of the noise that have got their loudness
        self._held = draw.held
        self._drawn = draw.fingers
        self._substeps = substeps
        self._touch = course.touch
        self.nominal_speed = sum(p.speed for p in draw.fingers) / 2
        self._to_go = self.nominal_speed * self._touch  # travel from here to the touch, m
        self._since = 0.0
        self._state = np.zeros(STATES) if at_rest else moving(draw)
        self._gap = np.full(2, np.nan)
        self._set_speed(0.0 if at_rest else self.nominal_speed)
        self._heard = self.loudness = 0.0 if at_rest else 1.0
        if at_rest:
            self._touch[:] = math.inf

    @property
    def now(self) -> float:
        """Instant of the newest sample, s from the run's start; 0 before the first."""
        return float(self.times[self.done - 1]) if self.done else 0.0

    @property
    def speed(self) -> float:
        """Speed that the drives are told from now on, mean of both, m/s; negative opens."""
        return self._speed

    @speed.setter
    def speed(self, speed: float) -> None:
        if speed == self._speed:
            return
        gone = self._speed * (self.now - self._since)
        self._to_go -= gone
        self._since = self.now
        self._set_speed(speed)
        apart = np.isnan(self._gap)
        coming = self.now + self._to_go / speed if speed > 0 else math.inf
        self._touch = np.where(apart, coming, self._touch)

    @property
    def drive_speed(self) -> float:
        """How fast the drives move now, mean of both, m/s."""
        return float(self._state[1] + self._state[FINGER_STATES + 1]) / 2

    @property
    def touched(self) -> tuple[bool, bool]:
        """Whether index and thumb have touched yet."""
        return not math.isnan(self._gap[0]), not math.isnan(self._gap[1])

    def advance(self, samples: int) -> NDArray[np.float64]:
        """Take the next samples.

        A change of :attr:`speed` takes effect after the newest sample.

        Returns
        -------
        ndarray
            As of :func:`firstcontact.twin.mechanics.integrate`, shape (samples,
            2, 3): buffer (V), contact force (N), indentation (m).

        Raises
        ------
        ValueError
            More samples than are left of the longest run, or less than 1.
        """
        end = self.done + samples
        if samples < 1 or end > self.times.size:
            raise ValueError(f"{samples} samples asked of a run that has {self.times.size} in all")
        # A piece starts at the newest sample, whose row is known already.
        begin = max(self.done - 1, 0)
        self._shape_noise(self.times[end - 1])
        out = np.empty((end - begin, 2, OUTPUTS))
        index, thumb = self._fingers
        integrate(
            index, thumb, self._held, self._touch, self.times[begin:end], self._noise,
            self._noise_dt, self._substeps, self._state, self._gap, out,
        )  # fmt: skip
        fresh = out[self.done - begin :]
        self.done = end
        return fresh

    def _set_speed(self, speed: float) -> None:
        self._speed = speed
        share = speed / self.nominal_speed
        index, thumb = self._drawn
        self._fingers = (
            index._replace(speed=share * index.speed),
            thumb._replace(speed=share * thumb.speed),
        )

    def _shape_noise(self, until: float) -> None:
        """Give the noise up to an instant its loudness, the kernel's next point included."""
        stop = min(int(until / self._noise_dt) + 2, self._noise.shape[1])
        if stop > self._shaped and not self._heard == self.loudness == 1.0:
            slope = np.linspace(self._heard, self.loudness, stop - self._shaped + 1)[1:]
            self._noise[:, self._shaped : stop] *= slope
        self._shaped = max(self._shaped, stop)
        self._heard = self.loudness
