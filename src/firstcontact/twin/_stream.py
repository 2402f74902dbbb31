"""A hand that picks one thing up after the other, as raw scans without an end."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import FINGERTIP_RATE, Command, Contact, InputError, Label
from firstcontact.twin._conditions import condition
from firstcontact.twin._draw import draw_pinch, generator
from firstcontact.twin._drive import LATENCY, Drive
from firstcontact.twin._fingertips import StreamFingertips, strip_contacts
from firstcontact.twin._household import OBJECT_SETS, draw_household_specimen, thing_named
from firstcontact.twin._household_object import HouseholdObject
from firstcontact.twin._lift import Lift
from firstcontact.twin._mechanics import CONTACT_FORCE, OUTPUTS
from firstcontact.twin._objects import TwinObject
from firstcontact.twin._outcome import DROPPED, slide
from firstcontact.twin._plan import PlannedPinch, planned_pinch
from firstcontact.twin._run import PinchRun
from firstcontact.twin._sensor import SCAN
from firstcontact.twin._stream_moves import PIECE, close_hand, open_hand, pieces

#: The open hand rests this long with its motor off, s.
REST = (0.6, 1.0)
#: Added to the drawn instant of the first contact, which so comes 200 to 220 ms after
#: the motor's start, 140 ms or more of it at full speed.
LEAD = 0.04
#: The hand that has squeezed holds for this long, s.
HOLD = (0.40, 0.50)
#: No pinch is longer, s.
LONGEST = 4.0
#: The session that all pinches of a stream belong to.
SESSION = "stream"
#: Pinches that are remembered.
REMEMBERED = 1000

Thing = TwinObject | HouseholdObject


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
    end
        First sample after the hold, where the hand begins to open; None before that.
    peak
        Largest grip force until then, N: the smaller one of both contacts'.
    lost
        "dropped" or "broken" where the hand has not held it until then: it is lifted as in the
        hand plant. The fingers feel a dropped object as if it were still there.
    """

    start: int
    label: Label
    truth: tuple[Contact, ...] = ()
    end: int | None = None
    peak: float | None = None
    lost: str | None = None


class TwinStream:
    """Rest, close, squeeze and hold, open, rest again: one object after the other.

    The same arguments give the same scans, however they are read. The hand is that of
    :func:`firstcontact.twin._simulate.simulate` with the same condition and seed.

    Parameters
    ----------
    condition_name
        "paper-rig" or "everyday".
    objects
        What is picked up, by name or as it is; each once a round, in another order
        each round. A name may be that of a set in
        :data:`firstcontact.twin._household.OBJECT_SETS`. All of the paper's by default.
    seed
        Of all random numbers.
    latency
        From a command to its effect, s. All else of the :class:`Drive` is its own.

    Attributes
    ----------
    ignored
        Commands that no closing was there for.

    Raises
    ------
    InputError
        Unknown condition or object, none at all, a negative seed, or a latency
        that cannot be.
    """

    def __init__(
        self,
        condition_name: str = "paper-rig",
        objects: Sequence[str | Thing] | None = None,
        seed: int = 0,
        latency: float = LATENCY,
    ) -> None:
        self._condition = condition(condition_name)
        self._drive = Drive(latency=latency)
        if seed < 0:
            raise InputError(f"seed is {seed}: use a whole number from 0 on")
        self._objects: list[Thing] = []
        for given in ("paper",) if objects is None else objects:
            if not isinstance(given, str):
                self._objects.append(given)
            elif given in OBJECT_SETS:
                self._objects += OBJECT_SETS[given]
            else:
                self._objects.append(thing_named(given))
        if not self._objects:
            raise InputError("the twin has no objects: give at least one")
        self.ignored = 0
        self._run: PinchRun | None = None  # while the hand takes commands
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
        self._chosen = None if name is None else thing_named(name)

    def command(self, command: Command) -> bool:
        """Order something of the closing that is going on; holds until the hand opens.

        It takes effect the drive's latency after the scan that was read last.

        Returns
        -------
        bool
            Whether there is a closing; otherwise the command is ignored and counted.

        Raises
        ------
        InputError
            A speed or force that is no number.
        """
        clipped = self._drive.clipped(command)
        if self._run is None:
            self.ignored += 1
            return False
        self._run.order(clipped, self._effect(self._run))
        return True

    def release(self) -> None:
        """Have the hand open now, and not when it has held; an open one stays as it is.

        It begins to open the drive's latency after the scan that was read last, to
        the next piece. What is commanded after it comes too late for this closing.
        """
        if self._run is not None:
            self._run.order(None, self._effect(self._run))
            self._run = None

    def _effect(self, run: PinchRun) -> int:
        return run.done - 1 - len(self._left) + self._drive.delay

    def read(self, samples: int) -> NDArray[np.uint16]:
        """The next scans.

        Returns
        -------
        ndarray
            Shape (samples, 6), in the order of :data:`firstcontact.twin._sensor.SCAN`.
        """
        parts = [self._left]
        there = len(self._left)
        while there < samples:
            first = self._tips.sample
            scans = self._tips.read(next(self._moves))
            self._note(first, scans)
            parts.append(scans)
            there += len(scans)
        joined = np.concatenate(parts)
        self._left = joined[samples:]
        return joined[:samples]

    def _move(self) -> Iterator[NDArray[np.float64]]:
        """Pieces of what :meth:`PinchRun.advance` gives, for ever."""
        while True:
            for _ in range(pieces(self._rng.uniform(*REST))):
                yield np.zeros((PIECE, 2, OUTPUTS))
            coming = self._next()
            key = f"{coming.label.specimen} {coming.number}"
            draw = draw_pinch(self._seed, self._condition, SESSION, coming.specimen, key)
            self._tips.take(draw)
            self.pinches.append(StreamPinch(self._tips.sample, coming.label))
            lead = round(LEAD * FINGERTIP_RATE)
            run = PinchRun(draw, LONGEST, lead, self._drive, at_rest=True)
            if coming.specimen.fragility is not None:
                run.limit = coming.specimen.fragility.draw(generator(self._seed, "limit", key))
            yield from self._pinch(run, coming.specimen)

    def _pinch(self, run: PinchRun, held: TwinObject) -> Iterator[NDArray[np.float64]]:
        """From rest to rest."""
        self._run = run
        peak = 0.0
        parts = []
        for motion in close_hand(run, float(self._rng.uniform(*HOLD))):
            parts.append(motion[..., CONTACT_FORCE])
            peak = max(peak, float(parts[-1].min(axis=1).max()))
            yield motion
        self._run = None
        lost = "broken" if run.broken_at is not None else _dropped(np.concatenate(parts), held)
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
        label = Label(one.name, one.shore_a, None, one.name, SESSION, one.role)
        return PlannedPinch(one, label, number)

    def _note(self, first: int, scans: NDArray[np.uint16]) -> None:
        """Add the contacts that came with these scans to the pinch they belong to."""
        if self.pinches:
            pinch = self.pinches[-1]
            new = strip_contacts(scans, first, pinch.truth)
            if new:
                self.pinches[-1] = replace(pinch, truth=(*pinch.truth, *new))


def _dropped(forces: NDArray[np.float64], held: TwinObject) -> str | None:
    """Whether an object falls when it is lifted after its first contact.

    Parameters
    ----------
    forces
        Of a closing, N, shape (samples, 2).
    held
        Its mass and friction.
    """
    touched = np.flatnonzero((forces > 0).any(axis=1))
    if not touched.size:
        return None
    lift = Lift().hanging(-int(touched[0]), len(forces))
    slid = np.zeros_like(forces)
    slide(forces, lift, held.mass, held.friction, 1 / FINGERTIP_RATE, np.zeros(2), slid)
    return "dropped" if slid[-1, 0] > DROPPED else None
