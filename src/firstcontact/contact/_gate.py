"""Gate that detects closings. A closing is a time in which the motor runs and no object is held.

The gate decides after each step, 3 ms of samples.

A detector measures its steady state at the start of a closing. If the detector began at rest, the
start of the motor would look like a contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, Calibration, ChannelKind, Layout, Physical, kernels
from firstcontact.signal import samples_in

#: Length of a step, s. Closings begin and end on this grid.
STEP = 0.003
#: Number of steps, 39 ms, over which rest and the settling of the motor are judged.
STEPS = 13
#: When most of STEPS steps are loud, the motor has run for at least this many steps.
HEARD_SINCE = STEPS // 2
#: The motor runs if the RMS of a piezo exceeds its noise floor by this factor. At rest the RMS
#: varies up to 1.3 times the floor. A quieter motor cannot disturb a detector.
RUNNING = 1.4
#: A taxel counts as loaded this far above its unloaded voltage, V. This takes some 0.1 N more than
#: the force at which Velostat begins to conduct. After a firm grip, creep keeps the voltage about
#: 0.1 V too high for a second.
LOADED = 0.3
#: Without a motor, rest opens the gate again this long after a contact, s.
REARM = 0.3


class Turn(Enum):
    """Change of the gate: it opens or it shuts."""

    OPENS = auto()
    SHUTS = auto()


@dataclass(frozen=True, slots=True)
class GateEvent:
    """Opening or shutting of the gate. ``sample`` is the first sample after the change."""

    turn: Turn
    sample: int


class _State(Enum):
    #: The past is unknown: wait for rest.
    LOST = auto()
    REST = auto()
    #: The motor has started. It is settling, or the hand still releases an object.
    STARTING = auto()
    OPEN = auto()


class ClosingGate:
    """Gate that opens when the motor has run for 39 ms without a held object, and shuts at rest.

    The gate decides every 3 ms, counted from the start of an epoch even after a gap. So the result
    depends neither on block sizes nor on samples that were lost at another time. The gate needs the
    noise floors of the calibration. Without them it opens at the first sample of each epoch and
    shuts at the end of the epoch. This suits recordings with one closing per epoch.

    A sensor that belongs to no finger is moved by a person, so no motor runs before a contact. With
    such a sensor the gate opens at rest. After a contact that was reported to :meth:`touched`, it
    opens again once the sensor has rested, at the earliest after 0.3 s.

    Parameters
    ----------
    layout
        Columns of the blocks.
    calibration
        Calibration with the noise floor of every finger that has a piezo, or None.

    Attributes
    ----------
    refused
        Number of motor starts since the gate last opened that did not open it because of a load.
    """

    def __init__(self, layout: Layout, calibration: Calibration | None) -> None:
        self._vibration = layout.columns(ChannelKind.VIBRATION)
        # The threshold of a load is in volts. In another unit it would hide every motor start.
        force = layout.columns(ChannelKind.FORCE)
        self._force = tuple(i for i in force if layout.column_channels[i].unit == "V")
        self._volts = Physical(layout, self._vibration + self._force, "C")
        floors = [calibration.noise(f) if calibration else None for f in layout.vibration_fingers]
        known_floors = [f for f in floors if f is not None]
        self._limit = RUNNING * np.array(known_floors) if len(known_floors) == len(floors) else None
        self._step = samples_in(STEP, layout.rate)
        self._by_hand = None in layout.vibration_fingers
        self._rearm = samples_in(REARM, layout.rate)
        self._due: int | None = None  # first sample at which it may open again
        self._grid = 0
        self.refused = 0
        self._open = False
        self._started = False
        self._next = 0
        self._epoch = 0

    @property
    def has_floors(self) -> bool:
        """True if the noise floors are known. Without them each epoch is one closing."""
        return self._limit is not None

    @property
    def resting(self) -> bool:
        """True if the hand was at rest in the last step."""
        return self._started and self._limit is not None and self._state is _State.REST

    @property
    def undecided(self) -> int:
        """Number of samples that can still come before the gate decides again."""
        return self._skipped + self._step - 1 - self._waiting_samples if self._started else 0

    def touched(self, sample: int) -> None:
        """Report a contact that began with this sample."""
        if self._by_hand:
            self._due = sample + self._rearm

    def update(self, block: Block) -> list[GateEvent]:
        """Process the next block.

        Returns
        -------
        list of GateEvent
            Events in order. If the block follows a gap or begins a new epoch, the first event can
            shut the gate at the end of the earlier samples.
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
        self._since = 0  # first step of this state
        self._waiting: list[NDArray[Any]] = []  # raw samples of an incomplete step
        self._waiting_samples = 0
        # The rest of a step that began in the gap is skipped.
        self._skipped = (self._grid - first_sample) % self._step if goes_on else 0
        self._grid = first_sample + self._skipped  # number of the first waiting sample
        self._steps = 0  # steps since the restart
        self.refused = 0
        # Sums of the last steps since the restart, and zeros before these.
        self._sums = np.zeros((STEPS, 2, len(self._vibration)))
        self._unloaded: NDArray[np.float64] | None = None
        self._held = -STEPS  # last step with a held object

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
        quiet = self._quiet(parts)
        events = self._turns(quiet, parts[:, :, len(self._vibration) :])
        self._grid += used
        self._steps += steps
        return events

    def _quiet(self, volts: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Return a mask of the steps at rest.

        A step is at rest if most of the 13 steps that end with it are quiet.

        ``volts`` holds piezos and taxels, shape (steps, samples, columns).
        """
        assert self._limit is not None
        fingers = len(self._vibration)
        if (module := kernels()) is not None:
            at_rest = np.empty(len(volts), np.bool_)
            module.quiet_steps(
                volts,
                volts.shape[2],
                fingers,
                self._step,
                self._sums,
                self._steps,
                self._limit,
                at_rest,
            )
            return at_rest
        new = step_sums(volts[:, :, :fingers])
        sums = np.concatenate([self._sums, new])
        self._sums = sums[-STEPS:]
        sums = sums[-min(self._steps, STEPS - 1) - len(new) :]
        quiet = np.zeros(len(new), dtype=np.bool_)  # unknown for the first steps
        if len(sums) >= STEPS:
            calm = np.all(median(step_powers(sums, self._step)) <= self._limit**2, axis=1)
            quiet[len(quiet) - len(calm) :] = calm
        return quiet

    def _turns(self, quiet: NDArray[np.bool_], felt: NDArray[np.float64]) -> list[GateEvent]:
        """Return the openings and shuttings of the gate in the steps of a block.

        ``felt`` holds the taxels, shape (steps, samples, taxels).
        """
        events: list[GateEvent] = []
        if self._state is _State.OPEN and not quiet.any():
            return events  # the usual case: held objects matter only before the gate opens
        force = felt.mean(axis=1)
        k = 0
        while k < len(quiet):
            number = self._steps + k
            if self._state in (_State.LOST, _State.OPEN):
                # The motor's steady state must begin after the gate's opening.
                first = max(k, self._since + STEPS - self._steps, self._first_due())
                change = _first(quiet, first)
                if change is None:
                    break
                if self._state is _State.OPEN:
                    events += self._shut(change)
                k = self._go(_State.REST, change)
                if self._by_hand:
                    events += self._reopen(change)
            elif self._state is _State.REST:
                change = _first(~quiet, k)
                reopening = None if self._due is None else _first(quiet, max(k, self._first_due()))
                if reopening is not None and (change is None or reopening < change):
                    events += self._reopen(reopening)
                    k = reopening + 1
                    continue
                self._learn_unloaded(quiet, force, k, change)
                if change is None:
                    break
                k = self._go(_State.STARTING, change)
                self._since -= HEARD_SINCE
            elif quiet[k]:
                self.refused += self._held >= self._since and number - self._since >= STEPS
                k = self._go(_State.REST, k) - 1
            else:
                if self._loaded(force[k]):
                    self._held = number
                due = self._due is None or self._step_sample(k) >= self._due
                if due and number - max(self._since, self._held) >= STEPS:
                    events += self._reopen(k)
                    self._go(_State.OPEN, k)
                k += 1
        return events

    def _first_due(self) -> int:
        """Return the step of this block from which on the gate may open again."""
        if self._due is None:
            return 0
        return -(-(self._due - self._grid) // self._step) - 1

    def _shut(self, k: int) -> list[GateEvent]:
        was_open, self._open = self._open, False
        return [GateEvent(Turn.SHUTS, self._step_sample(k))] if was_open else []

    def _reopen(self, k: int) -> list[GateEvent]:
        """Open the gate after step ``k``. Shut it first if it is open. Return the events."""
        events = self._shut(k)
        self._open, self._due, self.refused = True, None, 0
        return [*events, GateEvent(Turn.OPENS, self._step_sample(k))]

    def _go(self, state: _State, k: int) -> int:
        self._state = state
        self._since = self._steps + k
        return k + 1

    def _step_sample(self, k: int) -> int:
        return self._grid + (k + 1) * self._step

    def _loaded(self, force: NDArray[np.float64]) -> bool:
        return self._unloaded is not None and bool((force > self._unloaded + LOADED).any())

    def _learn_unloaded(
        self, quiet: NDArray[np.bool_], force: NDArray[np.float64], start: int, stop: int | None
    ) -> None:
        """Update the lowest force of each taxel at rest. A held object raises the force."""
        levels = force[start:stop]
        if force.shape[1] and len(levels):
            lowest = levels.min(axis=0)
            previous = self._unloaded
            self._unloaded = lowest if previous is None else np.minimum(previous, lowest)


def step_sums(piezo: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sum and the sum of squares of each step, shape (steps, 2, fingers).

    ``piezo`` has shape (steps, samples, fingers).
    """
    sums = np.empty((len(piezo), 2, piezo.shape[2]))
    sums[:, 0] = piezo.sum(axis=1)
    sums[:, 1] = (piezo**2).sum(axis=1)
    return sums


def step_powers(sums: NDArray[np.float64], samples: int) -> NDArray[np.float64]:
    """Return the power of each step in every run of 13 consecutive steps, without the run's level.

    The level is the median of the means of the run's steps. A knock does not change this median,
    because it lasts less than 7 steps.

    Parameters
    ----------
    sums
        Sums of :func:`step_sums`, shape (steps, 2, fingers), at least 13 steps.
    samples
        Samples per step.

    Returns
    -------
    ndarray
        Shape (steps - 12, fingers, 13), in the squared unit of the signal.
    """
    sums = np.ascontiguousarray(sums)
    step, kind, finger = sums.strides
    shape = (2, len(sums) - STEPS + 1, sums.shape[2], STEPS)
    # Faster than numpy's sliding_window_view, which takes longer than the rest of the function.
    total, squares = np.ndarray(shape, sums.dtype, sums, 0, (kind, step, finger, step))
    mean = median(total)[:, :, None] / samples
    power: NDArray[np.float64] = (squares - 2 * mean * total) / samples + mean**2
    return power


def median(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median along the last axis of odd length, 10 times faster than numpy.median."""
    middle = x.shape[-1] // 2
    ordered = x.copy()
    ordered.partition(middle)
    out: NDArray[np.float64] = ordered[..., middle]
    return out


def _first(flags: NDArray[np.bool_], start: int) -> int | None:
    """Return the position of the first true flag from ``start`` on, or None."""
    if start >= len(flags):
        return None
    change = start + int(np.argmax(flags[start:]))
    return change if flags[change] else None
