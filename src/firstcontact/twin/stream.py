"""A hand that picks one thing up after the other, as raw scans without an end."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core.errors import InputError
from firstcontact.core.layout import FINGERTIP_RATE, Finger
from firstcontact.core.pinch import Contact, Label
from firstcontact.twin.conditions import condition
from firstcontact.twin.draw import draw_pinch, generator
from firstcontact.twin.fingertips import Fingertips
from firstcontact.twin.mechanics import INDENTATION, OUTPUTS
from firstcontact.twin.objects import OBJECTS, TwinObject, object_named
from firstcontact.twin.parameters import FingerParameters
from firstcontact.twin.plan import Planned, planned
from firstcontact.twin.run import PinchRun
from firstcontact.twin.sensor import SCAN

#: The open hand rests this long with its motor off, s.
REST = (0.6, 1.0)
#: The motor gets to another speed in this time, s.
RAMP = 0.06
#: Added to the drawn instant of the first contact, which so comes 200 to 220 ms after
#: the motor's start, 140 ms or more of it at full speed.
LEAD = 0.04
#: Squeezing is over when the drives have slowed down to this share of their speed.
STALLED = 0.1
#: Then the hand holds with this force of each drive, N: below its stall force, so that
#: the speed loop damps what swings.
GRIP = 10.0
#: For this long, s.
HOLD = (0.40, 0.50)
#: How far apart skin and object are before the opening hand is stopped, m.
APART = 5e-3
#: What still swings when the hand has stopped has died down after this time, s.
SETTLE = 0.15
#: No pinch is longer, s.
LONGEST = 4.0
#: The session that all pinches of a stream belong to.
SESSION = "stream"
#: Pinches that are remembered.
REMEMBERED = 1000
#: Samples that are made at a time, 5 ms.
PIECE = 25


@dataclass(frozen=True, slots=True)
class StreamPinch:
    """One pinch of the stream.

    Parameters
    ----------
    start
        Sample at which the motor starts to close the hand.
    label
        What is pinched.
    truth
        Contacts as the strips tell them, in the order of time; those that have
        come so far.
    """

    start: int
    label: Label
    truth: tuple[Contact, ...] = ()


class TwinStream:
    """Rest, close, squeeze and hold, open, rest again: one object after the other.

    The same arguments give the same scans, however they are read. The hand is that of
    :func:`firstcontact.twin.simulate.simulate` with the same condition and seed.

    Parameters
    ----------
    condition_name
        "paper-rig" or "everyday".
    objects
        What is picked up, by name or as it is; each once a round, in another order
        each round. All of the paper's by default.
    seed
        Of everything by chance.

    Raises
    ------
    InputError
        Unknown condition or object, none at all, or a negative seed.
    """

    def __init__(
        self,
        condition_name: str = "paper-rig",
        objects: Sequence[str | TwinObject] | None = None,
        seed: int = 0,
    ) -> None:
        self._condition = condition(condition_name)
        if seed < 0:
            raise InputError(f"seed is {seed}: use a whole number from 0 on")
        given = tuple(OBJECTS) if objects is None else objects
        self._objects = [object_named(o) if isinstance(o, str) else o for o in given]
        if not self._objects:
            raise InputError("the twin has no objects: give at least one")
        self._seed = seed
        self._rng = generator(seed, condition_name, "stream")
        self._chosen: TwinObject | None = None
        self._waiting: list[TwinObject] = []
        self._round = 0
        self._taken: dict[str, int] = {}
        first = self._plan(self._objects[0], -1)
        draw = draw_pinch(seed, self._condition, SESSION, first.specimen, "first rest")
        self._tips = Fingertips(draw, generator(seed, condition_name, "stream", "converters"))
        self._moves = self._move()
        self._left = np.empty((0, len(SCAN)), np.uint16)
        #: The last pinches, oldest first. The newest may start at a sample not read yet.
        self.pinches: deque[StreamPinch] = deque(maxlen=REMEMBERED)

    @property
    def sample(self) -> int:
        """Number of the scan that is read next."""
        return self._tips.sample - len(self._left)

    def choose(self, name: str | None) -> None:
        """Pick up only this object from the next closing on; None goes back to the plan.

        Raises
        ------
        InputError
            There is no such object.
        """
        self._chosen = None if name is None else object_named(name)

    def read(self, samples: int) -> NDArray[np.uint16]:
        """The next scans.

        Returns
        -------
        ndarray
            Shape (samples, 6), in the order of :data:`firstcontact.twin.sensor.SCAN`.
        """
        pieces = [self._left]
        there = len(self._left)
        while there < samples:
            first = self._tips.sample
            scans = self._tips.read(next(self._moves))
            self._note(first, scans)
            pieces.append(scans)
            there += len(scans)
        joined = np.concatenate(pieces)
        self._left = joined[samples:]
        return joined[:samples]

    def _move(self) -> Iterator[NDArray[np.float64]]:
        """Pieces of what :meth:`PinchRun.advance` gives, for ever."""
        while True:
            for _ in range(_pieces(self._rng.uniform(*REST))):
                yield np.zeros((PIECE, 2, OUTPUTS))
            coming = self._next()
            key = f"{coming.label.specimen} {coming.number}"
            draw = draw_pinch(self._seed, self._condition, SESSION, coming.specimen, key)
            self._tips.take(draw)
            self.pinches.append(StreamPinch(self._tips.sample, coming.label))
            run = PinchRun(draw, LONGEST, round(LEAD * FINGERTIP_RATE), at_rest=True)
            yield from _pinch(run, float(self._rng.uniform(*HOLD)))

    def _next(self) -> Planned:
        kind = self._chosen
        if kind is None:
            if not self._waiting:
                key = (self._condition.name, "stream", "round", self._round)
                order = generator(self._seed, *key).permutation(len(self._objects))
                self._waiting = [self._objects[i] for i in order]
                self._round += 1
            kind = self._waiting.pop()
        number = self._taken.get(kind.name, 0)
        self._taken[kind.name] = number + 1
        return self._plan(kind, number)

    def _plan(self, kind: TwinObject, number: int) -> Planned:
        return planned(self._seed, self._condition, kind, SESSION, number, number)

    def _note(self, first: int, scans: NDArray[np.uint16]) -> None:
        """Add the contacts that came with these scans to the pinch they belong to."""
        if not self.pinches or len(self.pinches[-1].truth) == len(Finger):
            return
        pinch = self.pinches[-1]
        known = {c.finger for c in pinch.truth}
        new = []
        for f in Finger:
            closed = scans[:, 4 + f]
            if f not in known and closed.any():
                sample = first + int(np.argmax(closed))
                new.append(Contact(f, sample, sample))
        if new:
            new.sort(key=lambda c: c.sample)
            self.pinches[-1] = replace(pinch, truth=(*pinch.truth, *new))


def _pieces(duration: float) -> int:
    return round(duration * FINGERTIP_RATE / PIECE)


def _pinch(run: PinchRun, hold: float) -> Iterator[NDArray[np.float64]]:
    """Close, hold and open, from rest to rest."""
    yield from _ramp(run, run.nominal_speed)
    while not all(run.touched) or run.drive_speed > STALLED * run.nominal_speed:
        yield _piece(run)
    # A drive that stands pushes with its gain times the speed it is told.
    yield from _ramp(run, GRIP / FingerParameters().speed_gain)
    for _ in range(_pieces(hold)):
        yield _piece(run)
    yield from _ramp(run, -run.nominal_speed)
    while True:
        motion = _piece(run)
        yield motion
        if (motion[-1, :, INDENTATION] < -APART).all():
            break
    yield from _ramp(run, 0.0)
    for _ in range(_pieces(SETTLE)):
        yield _piece(run)


def _ramp(run: PinchRun, speed: float) -> Iterator[NDArray[np.float64]]:
    """Bring the hand to another speed without a jerk."""
    begin = run.speed
    steps = _pieces(RAMP)
    for k in range(steps):
        part = 0.5 - 0.5 * math.cos(math.pi * (k + 1) / steps)
        run.speed = begin + part * (speed - begin)
        yield _piece(run)


def _piece(run: PinchRun) -> NDArray[np.float64]:
    """The next piece; a motor that stalls or stands is not heard."""
    run.loudness = min(abs(run.drive_speed) / run.nominal_speed, 1.0)
    return run.advance(PIECE)
