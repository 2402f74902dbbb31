"""When a closing begins and ends in a stream: the motor runs, and nothing is held yet.

A detector measures its steady state from where a closing begins. Begun at rest,
it would take the start of the motor for a contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, Calibration, ChannelKind, Layout, Physical
from firstcontact.signal import samples_in

#: Length of a step, s: the grid on which a closing can begin or end.
STEP = 0.003
#: Rest, and the settling of the motor, are judged over so many steps: 39 ms.
STEPS = 13
#: A motor that is heard in most of these steps has run since this many steps ago.
HEARD_SINCE = STEPS // 2
#: The motor runs where the RMS of a piezo exceeds its noise floor by this factor. At
#: rest it scatters up to 1.3 times the floor; a motor that is not heard above this
#: cannot disturb a detector either.
RUNNING = 1.4
#: A taxel is loaded this far above its unloaded level, V: some 0.1 N more than makes
#: Velostat conduct. Its creep after a firm grip leaves it about 0.1 V high for a second.
LOADED = 0.3
#: Without a motor, rest opens the gate anew so long after a contact, s.
REARM = 0.3


class Turn(Enum):
    """What happens at the gate."""

    OPENS = auto()
    SHUTS = auto()


@dataclass(frozen=True, slots=True)
class GateEvent:
    """The gate opens or shuts before this sample."""

    turn: Turn
    sample: int


class _State(Enum):
    #: What went before is not known: wait for rest.
    LOST = auto()
    REST = auto()
    #: The motor has started, and either settles or still lets go of something.
    STARTING = auto()
    OPEN = auto()


class ClosingGate:
    """Opens when the motor has run for 39 ms with nothing held, shuts when it rests.

    Everything is decided on a grid of 3 ms that begins with an epoch and goes on behind a
    gap, so that blocks of any size give the same, and so does who lost samples on the
    way and who did not. Needs the noise floor of the
    calibration; without it the gate opens at each epoch's first sample and shuts
    at its end, as for recordings that hold one closing an epoch.

    A sensor that belongs to no finger is moved by a person, or things are moved against it: no
    motor is heard before a contact. For such a layout the gate opens at rest, too, and again when
    a contact of which :meth:`touched` tells is 0.3 s old and all is at rest.

    Parameters
    ----------
    layout
        The columns of the blocks.
    calibration
        With the noise floor of every finger that has a piezo, or None.
    """

    def __init__(self, layout: Layout, calibration: Calibration | None) -> None:
        self._vibration = layout.columns(ChannelKind.VIBRATION)
        # A load is a number of volts: in any other unit it would hide the start of each motor.
        force = layout.columns(ChannelKind.FORCE)
        self._force = tuple(i for i in force if layout.column_channels[i].unit == "V")
        self._volts = Physical(layout, self._vibration + self._force, "C")
        floors = [calibration.noise(f) if calibration else None for f in layout.vibration_fingers]
        known = [f for f in floors if f is not None]
        self._limit = RUNNING * np.array(known) if len(known) == len(floors) else None
        self._step = samples_in(STEP, layout.rate)
        self._by_hand = None in layout.vibration_fingers
        self._rearm = samples_in(REARM, layout.rate)
        self._due: int | None = None  # from this sample on it may open anew
        self._grid = 0
        self._open = False
        self._started = False
        self._next = 0
        self._epoch = 0

    @property
    def opened(self) -> bool:
        """Whether it is open now."""
        return self._open

    @property
    def has_floors(self) -> bool:
        """Whether it knows the noise floors; without them each epoch is one closing."""
        return self._limit is not None

    @property
    def resting(self) -> bool:
        """Whether what it heard last is a hand at rest."""
        return self._started and self._limit is not None and self._state is _State.REST

    @property
    def undecided(self) -> int:
        """So many more samples change nothing yet: the step they belong to is not whole."""
        return self._skipped + self._step - 1 - self._waiting_samples if self._started else 0

    def touched(self, sample: int) -> None:
        """A contact began with this sample."""
        if self._by_hand:
            self._due = sample + self._rearm

    def update(self, block: Block) -> list[GateEvent]:
        """Take the next block.

        Returns
        -------
        list of GateEvent
            In order. A sample number may lie up to one step before the block's
            own only where the block does not follow the one before: then the
            gate shuts where the samples ended.
        """
        events: list[GateEvent] = []
        if not self._started or block.first_sample != self._next or block.epoch != self._epoch:
            new_epoch = not self._started or block.epoch != self._epoch
            if self._open:
                events.append(GateEvent(Turn.SHUTS, self._next))
            self._restart(block.first_sample, block.epoch)
            if self._limit is None and new_epoch:
                self._open = True
                events.append(GateEvent(Turn.OPENS, block.first_sample))
        self._next = block.end
        if self._limit is not None:
            events += self._watch(block)
        return events

    def _restart(self, first_sample: int, epoch: int) -> None:
        goes_on = self._started and epoch == self._epoch
        self._started = True
        self._open = False
        self._epoch = epoch
        self._state = _State.LOST
        self._due = None
        self._since = 0  # step in which this state began
        self._waiting: list[NDArray[Any]] = []  # raw samples of a step that is not whole
        self._waiting_samples = 0
        # Behind a gap what is left of the step that began in it is not looked at.
        self._skipped = (self._grid - first_sample) % self._step if goes_on else 0
        self._grid = first_sample + self._skipped  # of the first sample that waits
        self._steps = 0  # seen in this stretch
        self._sums = np.zeros((0, 2, len(self._vibration)))  # of the last steps
        self._unloaded: NDArray[np.float64] | None = None
        self._held = -STEPS  # last step in which something was held

    def _watch(self, block: Block) -> list[GateEvent]:
        data = block.data[self._skipped :]
        self._skipped -= len(block.data) - len(data)
        self._waiting.append(data)
        self._waiting_samples += len(data)
        steps = self._waiting_samples // self._step
        if not steps:
            return []
        waiting = self._waiting[0] if len(self._waiting) == 1 else np.concatenate(self._waiting)
        used = steps * self._step
        self._waiting = [waiting[used:].copy()]
        self._waiting_samples -= used
        parts = self._volts(waiting[:used]).reshape(steps, self._step, -1)
        quiet = self._quiet(parts[:, :, : len(self._vibration)])
        events = self._turns(quiet, parts[:, :, len(self._vibration) :])
        self._grid += used
        self._steps += steps
        return events

    def _quiet(self, piezo: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Whether most of the 13 steps up to each are at rest, shape (steps,)."""
        assert self._limit is not None
        new = step_sums(piezo)
        sums = np.concatenate([self._sums, new])
        self._sums = sums[-(STEPS - 1) :]
        quiet = np.zeros(len(new), dtype=np.bool_)  # not known for the first steps
        if len(sums) >= STEPS:
            calm = np.all(median(step_powers(sums, self._step)) <= self._limit**2, axis=1)
            quiet[len(quiet) - len(calm) :] = calm
        return quiet

    def _turns(self, quiet: NDArray[np.bool_], felt: NDArray[np.float64]) -> list[GateEvent]:
        """Run the states over the steps of a block, from change to change.

        ``felt`` are the taxels, shape (steps, samples, taxels).
        """
        events: list[GateEvent] = []
        if self._state is _State.OPEN and not quiet.any():
            return events  # as for most of a closing: what is held need not be known
        force = felt.mean(axis=1)
        k = 0
        while k < len(quiet):
            number = self._steps + k
            if self._state in (_State.LOST, _State.OPEN):
                # The steady state of the motor must be younger than the gate's opening.
                first = max(k, self._since + STEPS - self._steps, self._first_due())
                found = _first(quiet, first)
                if found is None:
                    break
                if self._state is _State.OPEN:
                    events += self._shut(found)
                k = self._go(_State.REST, found)
                if self._by_hand:
                    events += self._reopen(found)
            elif self._state is _State.REST:
                found = _first(~quiet, k)
                anew = None if self._due is None else _first(quiet, max(k, self._first_due()))
                if anew is not None and (found is None or anew < found):
                    events += self._reopen(anew)
                    k = anew + 1
                    continue
                self._learn_unloaded(quiet, force, k, found)
                if found is None:
                    break
                k = self._go(_State.STARTING, found)
                self._since -= HEARD_SINCE
            elif quiet[k]:
                k = self._go(_State.REST, k) - 1
            else:
                if self._loaded(force[k]):
                    self._held = number
                due = self._due is None or self._sample_after(k) >= self._due
                if due and number - max(self._since, self._held) >= STEPS:
                    events += self._reopen(k)
                    self._go(_State.OPEN, k)
                k += 1
        return events

    def _first_due(self) -> int:
        """Step of those at hand from which on the gate may open anew."""
        if self._due is None:
            return 0
        return -(-(self._due - self._grid) // self._step) - 1

    def _shut(self, k: int) -> list[GateEvent]:
        was, self._open = self._open, False
        return [GateEvent(Turn.SHUTS, self._sample_after(k))] if was else []

    def _reopen(self, k: int) -> list[GateEvent]:
        """A closing begins behind a step; one that goes on ends there."""
        events = self._shut(k)
        self._open, self._due = True, None
        return [*events, GateEvent(Turn.OPENS, self._sample_after(k))]

    def _go(self, state: _State, k: int) -> int:
        self._state = state
        self._since = self._steps + k
        return k + 1

    def _sample_after(self, k: int) -> int:
        return self._grid + (k + 1) * self._step

    def _loaded(self, force: NDArray[np.float64]) -> bool:
        return self._unloaded is not None and bool((force > self._unloaded + LOADED).any())

    def _learn_unloaded(
        self, quiet: NDArray[np.bool_], force: NDArray[np.float64], start: int, stop: int | None
    ) -> None:
        """The lowest level at rest: something held at rest lies above it."""
        levels = force[start:stop]
        if force.shape[1] and len(levels):
            lowest = levels.min(axis=0)
            known = self._unloaded
            self._unloaded = lowest if known is None else np.minimum(known, lowest)


def step_sums(piezo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Sums and sums of squares of each step, (steps, samples, fingers) to (steps, 2, fingers)."""
    sums = np.empty((len(piezo), 2, piezo.shape[2]))
    sums[:, 0] = piezo.sum(axis=1)
    sums[:, 1] = (piezo**2).sum(axis=1)
    return sums


def step_powers(sums: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    """Power of each of 13 steps around their common mean, for every 13 that follow each other.

    The mean is the median of theirs: a knock or a click is loud, but not for seven steps.

    Parameters
    ----------
    sums
        Of :func:`step_sums`, shape (steps, 2, fingers), at least 13 steps.
    samples
        In a step.

    Returns
    -------
    ndarray
        Shape (steps - 12, fingers, 13), in the square of the signal's unit.
    """
    sums = np.ascontiguousarray(sums)
    step, kind, finger = sums.strides
    shape = (2, len(sums) - STEPS + 1, sums.shape[2], STEPS)
    # As numpy's sliding_window_view would, which takes longer than all that follows.
    total, squares = np.ndarray(shape, sums.dtype, sums, 0, (kind, step, finger, step))
    mean = median(total)[:, :, None] / samples
    power: NDArray[np.float64] = (squares - 2 * mean * total) / samples + mean**2
    return power


def median(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Along the last axis of odd length: what numpy.median gives, in a tenth of the time."""
    middle = x.shape[-1] // 2
    ordered = x.copy()
    ordered.partition(middle)
    out: NDArray[np.float64] = ordered[..., middle]
    return out


def _first(flags: NDArray[np.bool_], start: int) -> int | None:
    """Position of the first true flag from ``start`` on."""
    if start >= len(flags):
        return None
    found = start + int(np.argmax(flags[start:]))
    return found if flags[found] else None
