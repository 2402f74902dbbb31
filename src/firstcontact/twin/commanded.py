"""The mechanics of one pinch whose drives take commands while it runs."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.command import Command
from firstcontact.twin.draw import PinchDraw
from firstcontact.twin.drive import Drive
from firstcontact.twin.fragility import CRUSHED
from firstcontact.twin.mechanics import CONTACT_FORCE, OUTLINES, OUTPUTS, follow, integrate
from firstcontact.twin.objects import stiffened
from firstcontact.twin.run import SUBSTEPS, drawn_course, moving

#: So long after both contacts the mechanics is stepped as coarsely as before them, s:
#: what is left is slow.
CALM = 0.03


class CommandedRun:
    """A drawn pinch that closes as drawn until the first command takes effect.

    Until then each finger touches at its drawn instant and the motor is heard at its
    full strength, as in :class:`firstcontact.twin.run.PinchRun`. The first command fixes
    where the object is: where a finger still on its way would have met it. From then on
    a finger touches when its skin gets there, and the motor is as loud as it is fast.

    How a run is cut into pieces changes nothing.

    Parameters
    ----------
    draw
        The chance in it; a run uses it up.
    drive
        What the commands go through.
    duration
        The longest that the run can take, s, without ``lead``; longer than the
        draw's second contact is away.
    lead
        Samples before the instant that the draw's timing counts from.

    Attributes
    ----------
    times
        Sampling instants, s from the run's start, shape (samples,).
    done
        Samples that have been taken.
    nominal
        Closing speed as drawn, the mean of both fingers, m/s.
    limit
        Force at which the object breaks, N; may be set.
    broken_at
        Number of the sample that showed it broken.
    """

    def __init__(self, draw: PinchDraw, drive: Drive, duration: float, lead: int) -> None:
        self._course = drawn_course(draw, duration, lead)
        self.times = self._course.times
        if self.times[-1] <= self._course.touch.max():
            raise ValueError(f"{duration} s is over before the second contact of the pinch")
        self.done = 0
        self.nominal = sum(p.speed for p in draw.fingers) / 2
        self.limit = math.inf
        self.broken_at: int | None = None
        self._drive = drive
        self._fingers = draw.fingers
        self._shares = np.array([p.speed / self.nominal for p in draw.fingers])
        self._held = draw.held
        self._state = moving(draw)
        self._gap = np.full(2, np.nan)
        self._touch = self._course.touch
        self._touched = np.full(2, np.nan)
        self._orders: list[tuple[int, Command]] = []
        self._told: Command | None = None
        # Reference speed when the command took effect that holds now, and its sample.
        self._from = self.nominal
        self._since = 0

    def tell(self, command: Command, effect: int) -> None:
        """Order; takes effect after the sample of number ``effect``, counted with the lead.

        Orders come in the order of their effects, none before the newest sample. Of two
        for one sample the later counts.
        """
        if self._orders and self._orders[-1][0] == effect:
            self._orders.pop()
        self._orders.append((effect, self._drive.clipped(command)))

    def advance(self, samples: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Take the next samples, all that are left where that is less.

        Returns
        -------
        tuple
            As of :func:`firstcontact.twin.mechanics.follow`: buffer (V), contact force
            (N), indentation (m; NaN where it is not known where the face is), shape
            (samples, 2, 3); squeeze (m) and drive speed (m/s), shape (samples, 2).
        """
        end = min(self.done + samples, self.times.size)
        motion, body = [np.empty((0, 2, OUTPUTS))], [np.empty((0, OUTLINES))]
        while self.done < end:
            # A piece starts at the newest sample, whose row is known already.
            begin = max(self.done - 1, 0)
            while self._orders and self._orders[0][0] <= begin:
                self._obey(self._orders.pop(0)[1], begin)
            stop = min(end, self._orders[0][0] + 1) if self._orders else end
            out, lines = self._piece(begin, stop)
            motion.append(out[self.done - begin :])
            body.append(lines[self.done - begin :])
            self.done = begin + len(out)
        return np.concatenate(motion), np.concatenate(body)

    def _piece(self, begin: int, stop: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        out = np.empty((stop - begin, 2, OUTPUTS))
        lines = np.empty((stop - begin, OUTLINES))
        intervals = max(stop - begin - 1, 1)
        drive = np.empty((intervals, 4))
        index, thumb = self._fingers
        if self._told is None:
            drive[:] = (index.speed, thumb.speed, self._drive.force, self._drive.force)
        else:
            drive[:, :2] = self._references(begin, intervals)[:, np.newaxis] * self._shares
            drive[:, 2:] = self._told.force
        limit = self.limit if self.broken_at is None else math.inf
        taken = follow(
            index, thumb, self._held, self._touch, self.times[begin:stop], self._course.noise,
            self._course.noise_dt, SUBSTEPS, drive, self._drive.back_damping,
            0.0 if self._told is None else self.nominal, limit,
            math.inf if self._told is None else CALM, self._state, self._gap,
            self._touched, out, lines,
        )  # fmt: skip
        if taken < stop - begin or out[taken - 1, :, CONTACT_FORCE].max() > limit:
            self.broken_at = begin + taken - 1
            self._held = stiffened(self._held, CRUSHED)
        return out[:taken], lines[:taken]

    def _obey(self, command: Command, at: int) -> None:
        if self._told is None:
            self._place()
        else:
            self._from = float(self._references(at - 1, 1)[0])
        self._since = at
        self._told = command

    def _references(self, begin: int, intervals: int) -> NDArray[np.float64]:
        """Mean reference speed of so many intervals from that sample on, m/s."""
        assert self._told is not None
        counted = np.arange(1, intervals + 1) + (begin - self._since)
        return self._drive.references(self._from, self._told.speed, counted)

    def _place(self) -> None:
        """Fix where the object is by letting the pinch run on as drawn, aside."""
        begin = max(self.done - 1, 0)
        if np.isnan(self._gap).any():
            stop = int(np.searchsorted(self.times, self._touch.max())) + 1
            times = self.times[begin:stop]
            integrate(
                *self._fingers, self._held, self._touch, times, self._course.noise,
                self._course.noise_dt, SUBSTEPS, self._state.copy(), self._gap,
                np.empty((times.size, 2, OUTPUTS)),
            )  # fmt: skip
        self._touch = np.full(2, math.inf)
