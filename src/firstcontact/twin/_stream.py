"""Endless raw scans of a simulated hand that picks up one object after another."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import ArgumentError, Command, Contact, Label
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.twin._run import PinchRun
from firstcontact.twin.draw import condition, draw_pinch, generator
from firstcontact.twin.drive import LATENCY, Drive, Positions
from firstcontact.twin.household import (
    OBJECT_SETS,
    HouseholdObject,
    draw_household_specimen,
    find_object,
)
from firstcontact.twin.mechanics import CONTACT_FORCE, INDENTATION, OUTPUTS, FingerParameters
from firstcontact.twin.objects import TwinObject
from firstcontact.twin.outcome import DROPPED, Lift, slide
from firstcontact.twin.sensor import ScanStream, StreamFingertips, strip_contacts
from firstcontact.twin.simulation import PlannedPinch, planned_pinch

#: Time for a change of the motor's speed, s.
RAMP = 0.06
#: A drive below this share of its speed counts as stalled, which ends the squeeze.
STALLED = 0.1
#: Longest squeeze of a commanded hand, s after the motor's start.
PATIENCE = 2.0
#: Force of each drive in the hold, N. It is below the stall force, so that the speed loop damps
#: oscillations.
GRIP = 10.0
#: Distance between skin and object at which the opening hand stops, m.
APART = 5e-3
#: Time for oscillations to decay after the hand has stopped, s.
SETTLE = 0.15
#: Number of samples computed at a time, 5 ms.
PIECE = 25


def piece_count(duration: float) -> int:
    """Return the number of pieces of :data:`PIECE` samples that last about ``duration`` s."""
    return round(duration * FINGERTIP_RATE / PIECE)


def close_hand(run: PinchRun, hold: float) -> Iterator[NDArray[np.float64]]:
    """Yield the motion of the fingers while the hand closes, and then holds for ``hold`` s.

    Each array has the shape (samples, 2, OUTPUTS). A release of the hand ends the closing earlier.
    """
    for motion in _squeeze(run, hold):
        yield motion
        if run.released:
            return


def open_hand(run: PinchRun) -> Iterator[NDArray[np.float64]]:
    """Yield the motion of the fingers while the hand opens, until both are free and at rest.

    Each array has the shape (samples, 2, OUTPUTS).
    """
    yield from _ramp(run, -run.nominal_speed)
    while True:
        motion = _piece(run)
        yield motion
        if (motion[-1, :, INDENTATION] < -APART).all():
            break
    yield from _ramp(run, 0.0)
    for _ in range(piece_count(SETTLE)):
        yield _piece(run)


def _squeeze(run: PinchRun, hold: float) -> Iterator[NDArray[np.float64]]:
    yield from _ramp(run, run.nominal_speed)
    while not _squeezed(run):
        yield _piece(run)
    # A stalled drive pushes with its gain times the reference speed.
    yield from _ramp(run, GRIP / FingerParameters().speed_gain)
    for _ in range(piece_count(hold)):
        yield _piece(run)


def _squeezed(run: PinchRun) -> bool:
    if run.broken_at is not None:
        return True  # the remains never stall the hand
    if run.commanded and run.done > PATIENCE * FINGERTIP_RATE:
        return True
    return all(run.touched) and run.drive_speed <= STALLED * run.nominal_speed


def _ramp(run: PinchRun, speed: float) -> Iterator[NDArray[np.float64]]:
    """Yield the motion of the fingers while their speed changes to ``speed``, m/s.

    Stop earlier if a command takes effect.
    """
    begin = run.speed
    steps = piece_count(RAMP)
    for k in range(steps):
        if run.commanded:
            return
        share = 0.5 - 0.5 * math.cos(math.pi * (k + 1) / steps)
        run.speed = begin + share * (speed - begin)
        yield _piece(run)


def _piece(run: PinchRun) -> NDArray[np.float64]:
    """Simulate the next samples with the noise of the motor, which is louder at higher speed.

    Return the motion of the fingers, shape (PIECE, 2, OUTPUTS).
    """
    run.loudness = min(abs(run.drive_speed) / run.nominal_speed, 1.0)
    return run.advance(PIECE)


#: Range of the time for which the open hand rests with its motor off, s.
REST = (0.6, 1.0)
#: Rest after a closing on request, s: time to look at its estimate, and to request another.
LONG_REST = 10.0
#: Time added to the drawn first contact, s. The contact then comes 200 to 220 ms after the motor's
#: start, and the hand closes at full speed for at least the last 140 ms of them.
LEAD = 0.04
#: Range of the time for which the hand holds the object after squeezing it, s.
HOLD = (0.40, 0.50)
#: Longest pinch, s.
LONGEST = 4.0
#: Session name of all pinches of a stream.
SESSION = "stream"
#: Number of past pinches that are kept in memory.
REMEMBERED = 1000

Thing = TwinObject | HouseholdObject


@dataclass(frozen=True, slots=True)
class StreamPinch:
    """Pinch in the endless stream of a simulated hand: label, true contacts and outcome.

    ``start`` and ``end`` are sample numbers, ``peak`` is the highest grip force, N. ``lost`` is
    "broken" or "dropped", or None if the hand kept the object. Until the hand opens, ``end`` and
    ``peak`` are None.
    """

    start: int
    label: Label
    truth: tuple[Contact, ...] = ()
    end: int | None = None
    peak: float | None = None
    lost: str | None = None


class TwinStream(ScanStream):
    """Simulated hand that picks up one object after another, as an endless stream of scans.

    A scan holds one reading of each channel. In each cycle the hand rests, closes, squeezes, holds
    and opens. The same arguments and commands give the same scans. The hand is that of
    :func:`firstcontact.twin.simulate` with the same condition and seed.

    Parameters
    ----------
    condition_name
        "paper-rig" or "everyday".
    objects
        Objects to pick up, or their names, or names of the sets in
        :data:`firstcontact.twin.household.OBJECT_SETS`. By default all objects of the paper. In a
        round the hand picks up each object once, in random order.
    seed
        Random seed.
    latency
        Time from a command to its effect, s. The drive otherwise has the defaults of
        :class:`Drive`.

    Attributes
    ----------
    ignored
        Number of commands without effect, because the hand was not closing or holding.
    positions
        Simulated position sensor of the fingers' drives.

    Raises
    ------
    InputError
        The condition or an object is unknown, there are no objects, or the seed or the latency is
        negative.
    """

    def __init__(
        self,
        condition_name: str = "paper-rig",
        objects: Sequence[str | Thing] | None = None,
        seed: int = 0,
        latency: float = LATENCY,
    ) -> None:
        super().__init__()
        self._condition = condition(condition_name)
        self._drive = Drive(latency=latency)
        if seed < 0:
            raise ArgumentError(
                f"the seed is {seed}: use a whole number from 0 on", parameter="seed"
            )
        self._objects: list[Thing] = []
        for given in ("paper",) if objects is None else objects:
            if not isinstance(given, str):
                self._objects.append(given)
            elif given in OBJECT_SETS:
                self._objects += OBJECT_SETS[given]
            else:
                self._objects.append(find_object(given))
        if not self._objects:
            raise ArgumentError("the twin has no objects: give at least one")
        self.ignored = 0
        self.positions = Positions(generator(seed, condition_name, "stream", "positions"))
        self._run: PinchRun | None = None  # set while the hand takes commands
        self._is_requested = False
        self._seed = seed
        self._rng = generator(seed, condition_name, "stream")
        self._chosen: Thing | None = None
        self._waiting: list[Thing] = []
        self._round = 0
        self._taken: dict[str, int] = {}
        first = self._plan(self._objects[0], -1)
        draw = draw_pinch(seed, self._condition, SESSION, first.specimen, "first rest")
        self._tips = StreamFingertips(draw, generator(seed, condition_name, "stream", "converters"))
        self._moves = self._move()
        #: Last pinches, oldest first. The newest can start at a sample that was not read yet.
        self.pinches: deque[StreamPinch] = deque(maxlen=REMEMBERED)

    @property
    def sample(self) -> int:
        """Number of the next scan that :meth:`read` returns, counted from 0."""
        return self._tips.sample - len(self._left)

    def choose(self, name: str | None) -> None:
        """Pick up only the named object from the next closing on; None returns to all objects.

        Raises
        ------
        InputError
            There is no such object.
        """
        self._chosen = None if name is None else find_object(name)

    def command(self, command: Command) -> bool:
        """Give a command for the current closing. It applies until the next one, or the hand opens.

        The command takes effect after the drive's latency, counted from the last scan that was
        read.

        Returns
        -------
        bool
            False if the hand is open or opening. It then ignores the command, and counts it.

        Raises
        ------
        InputError
            Speed or force is not a number.
        """
        clipped = self._drive.clipped(command)
        if self._run is None:
            self.ignored += 1
            return False
        self._run.order(clipped, self._effect(self._run))
        return True

    def release(self) -> None:
        """Open the hand now instead of after holding. An open hand stays open.

        The hand begins to open after the latency of the drive, counted from the last scan that was
        read. The current closing ignores later commands.
        """
        if self._run is not None:
            self._run.order(None, self._effect(self._run))
            self._run = None

    def close(self) -> None:
        """Open the hand if it is closing or holding, then begin the next closing without a rest.

        After this closing the hand rests for :data:`LONG_REST`, or until the next such request.
        """
        self._is_requested = True
        self.release()

    def _effect(self, run: PinchRun) -> int:
        return run.done - 1 - len(self._left) + self._drive.delay

    def _next_scans(self) -> NDArray[np.uint16]:
        first, motion = self._tips.sample, next(self._moves)
        self.positions.add(motion, first)
        scans = self._tips.read(motion)
        self._add_contacts(first, scans)
        return scans

    def _move(self) -> Iterator[NDArray[np.float64]]:
        """Yield the motion of the fingers without end, shape (samples, 2, OUTPUTS) each."""
        was_requested = False
        while True:
            rest = self._rng.uniform(*REST)
            for _ in range(piece_count(LONG_REST if was_requested else rest)):
                if self._is_requested:
                    break
                yield np.zeros((PIECE, 2, OUTPUTS))
            was_requested, self._is_requested = self._is_requested, False
            coming = self._next()
            key = f"{coming.label.specimen} {coming.number}"
            draw = draw_pinch(self._seed, self._condition, SESSION, coming.specimen, key)
            self._tips.use_draw(draw)
            self.positions.zero()  # the fingers are farther apart than they opened
            self.pinches.append(StreamPinch(self._tips.sample, coming.label))
            lead = round(LEAD * FINGERTIP_RATE)
            run = PinchRun(draw, LONGEST, lead, self._drive, at_rest=True)
            if coming.specimen.fragility is not None:
                run.limit = coming.specimen.fragility.draw(generator(self._seed, "limit", key))
            yield from self._pinch(run, coming.specimen)

    def _pinch(self, run: PinchRun, held_object: TwinObject) -> Iterator[NDArray[np.float64]]:
        """Yield the motion of the fingers while they close on ``held_object``, hold it, and open.

        The outcome of the pinch is stored before the hand opens.
        """
        self._run = run
        peak = 0.0
        parts = []
        for motion in close_hand(run, float(self._rng.uniform(*HOLD))):
            parts.append(motion[..., CONTACT_FORCE])
            peak = max(peak, float(parts[-1].min(axis=1).max()))
            yield motion
        self._run = None
        lost = (
            "broken" if run.broken_at is not None else _dropped(np.concatenate(parts), held_object)
        )
        self.ignored += run.withdraw()
        self.pinches[-1] = replace(self.pinches[-1], end=self._tips.sample, peak=peak, lost=lost)
        yield from open_hand(run)

    def _next(self) -> PlannedPinch:
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

    def _plan(self, kind: Thing, number: int) -> PlannedPinch:
        if isinstance(kind, TwinObject):
            return planned_pinch(self._seed, self._condition, kind, SESSION, number, number)
        one = draw_household_specimen(self._seed, self._condition, kind, 0)
        label = Label(one.name, one.shore_a, None, one.name, SESSION, one.role, one.shape)
        return PlannedPinch(one, label, number)

    def _add_contacts(self, first: int, scans: NDArray[np.uint16]) -> None:
        """Add the contacts that the copper strips show in ``scans`` to the newest pinch.

        ``first`` is the number of the first scan.
        """
        if self.pinches:
            pinch = self.pinches[-1]
            new = strip_contacts(scans, first, pinch.truth)
            if new:
                self.pinches[-1] = replace(pinch, truth=(*pinch.truth, *new))


def _dropped(forces: NDArray[np.float64], held_object: TwinObject) -> str | None:
    """Return "dropped" if the hand would lose the object during a lift, else None.

    ``forces`` are the contact forces of both fingers, N, shape (samples, 2).
    """
    touched = np.flatnonzero((forces > 0).any(axis=1))
    if not touched.size:
        return None
    lift = Lift().hanging(-int(touched[0]), len(forces))
    slid = np.zeros_like(forces)
    slide(
        forces, lift, held_object.mass, held_object.friction, 1 / FINGERTIP_RATE, np.zeros(2), slid
    )
    return "dropped" if slid[-1, 0] > DROPPED else None
