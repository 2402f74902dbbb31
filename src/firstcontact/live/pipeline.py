"""Samples in, contacts and estimates out: the objects of the study, fed block by block."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from firstcontact.contact.closing import ClosingBegan, ClosingEnded, Closings, ClosingSamples
from firstcontact.contact.detector import Detector
from firstcontact.core import (
    Block,
    Calibration,
    ChannelKind,
    Contact,
    Finger,
    InputError,
    Layout,
    joined,
)
from firstcontact.core.pinch import first_closed
from firstcontact.live._ledger import Ledger
from firstcontact.live.events import Armed, Case, Estimated, Event, PinchDone, Refused, Touched
from firstcontact.signal import samples_in
from firstcontact.signal.windowing import ContactWindow, WindowStream

if TYPE_CHECKING:
    from firstcontact.stiffness import Model
    from firstcontact.stiffness.interval import Interval

#: A pinch is over so long after its first contact (or after the longest window, if
#: that is longer), s: all offsets are shorter.
AFTER = 0.2
#: Where nothing is due, samples are worked on in lots of this length, s: each wakes a core that
#: has grown cold, and a page draws no oftener.
IDLE = 0.024


@dataclass(frozen=True, slots=True)
class ModelWithInterval:
    """A model and the interval around its answers, None where it has none."""

    model: Model
    interval: Interval | None = None

    @classmethod
    def load(cls, folder: Path) -> ModelWithInterval:
        """As a model's folder holds them; InputError if it is damaged or there is none."""
        from firstcontact.stiffness import load_interval, load_model

        return cls(load_model(folder), load_interval(folder))

    def bounds(self, value: float, window: NDArray[np.float32]) -> tuple[float, float, float]:
        """Lower and upper bound of an answer about a window, and the level of the interval."""
        interval = self.interval
        if interval is None:
            return value, value, 0.0
        if not interval.scaled:
            return *interval.around(value), interval.level
        spread = self.model.spread(window[None])
        if spread is None:
            raise InputError("the model's interval is scaled by a spread that it has not")
        return *interval.around(value, float(spread[0])), interval.level


@dataclass(slots=True)
class _Pinch:
    """What is known of the closing that goes on."""

    armed: int
    epoch: int
    windows: WindowStream
    asked: int  # windows still to come
    end: int = 0
    contacts: list[Contact] = field(default_factory=list)
    estimates: list[Estimated] = field(default_factory=list)
    strips: dict[Finger, int] = field(default_factory=dict)
    open_strips: set[Finger] = field(default_factory=set)
    refused: str = ""


class Pipeline:
    """Detects, cuts windows and estimates, as samples come.

    A closing gives exactly what the same detector and models give offline for a
    pinch that is cut out from where it began, whatever the blocks.

    Parameters
    ----------
    layout
        The columns of the blocks.
    detector
        Fitted or loaded.
    models
        Models, each for windows of its own length; an estimate comes as soon as
        each window is complete.
    calibration
        With the noise floors of the fingers; without, a closing begins with each
        epoch.
    clock
        Gives the host's time, s.

    Raises
    ------
    InputError
        A detector or model that is not for this layout.

    Notes
    -----
    One made-up pinch is worked on before the first real one, which so does not
    pay for what is loaded or built late.
    """

    def __init__(
        self,
        layout: Layout,
        detector: Detector,
        models: Sequence[ModelWithInterval] = (),
        calibration: Calibration | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        for entry in models:
            spec = entry.model.spec
            spec.require_rate(layout.rate)
            if spec.channels != 1:
                raise InputError(
                    f"the model takes {spec.channels} channels and live windows have the one of "
                    "the finger that touched: train a model on these"
                )
        self.layout = layout
        self.ledger = Ledger(layout.rate)
        self._models = {a.model.spec.duration: a for a in models}
        if len(self._models) < len(models):
            raise InputError(
                "two models are for windows of the same length: give one of each length"
            )
        self._rehearse(Closings(layout, detector))
        self._closings = Closings(layout, detector, calibration)
        self._clock = clock
        longest = max((a.model.spec.duration for a in models), default=0.0)
        self._after = samples_in(max(AFTER, 1.5 * longest), layout.rate)
        self._idle = samples_in(IDLE, layout.rate)
        self._strips = {f: layout.columns(ChannelKind.STRIP, f) for f in Finger}
        self._pinch: _Pinch | None = None
        self._number = 0
        self._waiting: list[Block] = []
        self._waiting_samples = 0
        self._lot = self._idle  # samples that are worked on together

    def update(self, block: Block, host: float) -> Iterator[Event]:
        """Take the next block: what is found in it, in order, each as soon as it is known.

        What this gives must be gone through to its end before the next block.

        Parameters
        ----------
        block
            The samples.
        host
            When its last byte had been read, on the host's clock, s.
        """
        waiting = self._waiting
        if waiting and (waiting[-1].end, waiting[-1].epoch) != (block.first_sample, block.epoch):
            yield from self._work(host)
        self._waiting.append(block)
        self._waiting_samples += len(block.data)
        if self._waiting_samples >= self._lot:
            yield from self._work(host)

    @property
    def closing(self) -> bool:
        """Whether a closing is going on."""
        return self._closings.open

    @property
    def due(self) -> int:
        """So many more samples are needed before anything can be found in them; at least 1."""
        return max(1, self._lot - self._waiting_samples)

    def finish(self) -> list[Event]:
        """No more samples come: what is still known of the last pinch."""
        events = list(self._work(self._clock())) if self._waiting else []
        if self._pinch is not None:
            events += self._end(self._closings.end, "the stream ended")
        return events

    def _rehearse(self, closings: Closings) -> None:
        """Detect and answer once, for something that sounds like a contact."""
        rate = self.layout.rate
        t = np.arange(samples_in(0.3, rate)) / rate - 0.15
        noise = np.random.default_rng(0).standard_normal((len(t), self.layout.width))
        ring = np.where(t > 0, np.exp(-t.clip(0) / 0.01) * np.sin(900.0 * t), 0.0)
        volts = 0.005 * noise + 0.5 * ring[:, None]
        scale = np.array([c.scale for c in self.layout.of_columns])
        offset = np.array([c.offset for c in self.layout.of_columns])
        windows = WindowStream(self.layout, tuple(self._models))
        for stage in closings.update(Block(volts / scale + offset)):
            if isinstance(stage, ClosingSamples):
                for window in windows.update(stage.block, stage.contacts[:1]):
                    self._models[window.duration].model.predict_one(window.samples)

    def _work(self, host: float) -> Iterator[Event]:
        began = self._clock()
        (block,) = joined(self._waiting)
        self._waiting = []
        self._waiting_samples = 0
        for stage in self._closings.update(block):
            match stage:
                case ClosingBegan():
                    self._begin(stage)
                    yield Armed(stage.sample, stage.epoch)
                case ClosingSamples():
                    yield from self._go_on(stage, host)
                case ClosingEnded():
                    why = "" if stage.whole else "samples were lost"
                    yield from self._end(stage.sample, why)
        window = None if self._pinch is None else self._pinch.windows.due
        self._lot = min(n for n in (self._idle, self._closings.due, window) if n is not None)
        self.ledger.worked(self._clock() - began, len(block.data))

    def _begin(self, stage: ClosingBegan) -> None:
        windows = WindowStream(self.layout, tuple(self._models))
        self._pinch = _Pinch(stage.sample, stage.epoch, windows, len(self._models))

    def _go_on(self, went: ClosingSamples, host: float) -> list[Event]:
        pinch = self._pinch
        if pinch is None:
            return []
        # By the sample that each became known with: the order is the same for all blocks.
        events: list[tuple[int, Event]] = []
        told = []
        for contact in went.contacts:
            if not pinch.contacts:
                pinch.end = contact.sample + self._after
                told = [contact]
            elif contact.decided >= pinch.end:
                continue
            first = not pinch.contacts
            pinch.contacts.append(contact)
            events.append((contact.decided, Touched(contact, first, pinch.epoch, self._clock())))
        self._watch_strips(pinch, went.block)
        if pinch.asked > 0:
            refused = pinch.windows.refused
            for window in pinch.windows.update(went.block, told):
                # A short window can be whole before its contact is decided.
                known = max(window.complete, window.contact.decided)
                waited = (went.block.end - 1 - known) / self.layout.rate
                events.append((known, self._estimate(pinch, window, known, host, waited)))
                pinch.asked -= 1
            if pinch.windows.refused > refused:
                pinch.asked -= pinch.windows.refused - refused
                dead = self._refuse(pinch, "the window is not whole, or the piezo is dead")
                events.append((went.block.end, dead))
        events.sort(key=lambda known: known[0])
        found = [event for _, event in events]
        if pinch.contacts and went.block.end >= pinch.end:
            found += self._end(pinch.end, "")
        return found

    def _estimate(
        self, pinch: _Pinch, window: ContactWindow, known: int, host: float, waited: float
    ) -> Estimated | Refused:
        entry = self._models[window.duration]
        try:
            value = entry.model.predict_one(window.samples)
            low, high, level = entry.bounds(value, window.samples)
        except InputError as error:
            return self._refuse(pinch, str(error))
        if not (math.isfinite(value) and math.isfinite(low) and math.isfinite(high)):
            return self._refuse(pinch, "the model's answer is no finite number")
        others = pinch.contacts[1:]
        late = any(c.decided <= known for c in others)
        now = self._clock()
        estimate = Estimated(
            contact=window.contact,
            value=value,
            low=low,
            high=high,
            level=level,
            duration=entry.model.spec.duration,
            complete=known,
            epoch=pinch.epoch,
            case=Case.TOO_LATE if late else Case.IN_TIME,
            used=not late,
            host=now,
            compute=now - host,
            waited=waited,
        )
        pinch.estimates.append(estimate)
        self.ledger.add(estimate)
        return estimate

    def _hindsight(self, pinch: _Pinch, estimate: Estimated) -> Case:
        """Whether an estimate was out before the second contact happened."""
        out = estimate.contact.sample + estimate.after(self.layout.rate) * self.layout.rate
        late = any(c.sample <= out for c in pinch.contacts[1:])
        return Case.TOO_LATE if late else Case.IN_TIME

    def _refuse(self, pinch: _Pinch, why: str) -> Refused:
        pinch.refused = why
        return Refused(pinch.contacts[0], why, pinch.epoch)

    def _watch_strips(self, pinch: _Pinch, block: Block) -> None:
        """Note where each strip closed for the first time in this closing."""
        for finger, columns in self._strips.items():
            if not columns or finger in pinch.strips:
                continue
            closed = block.data[:, columns[0]] > 0
            if finger not in pinch.open_strips:
                if closed.all():
                    continue  # held since before this closing
                pinch.open_strips.add(finger)
                closed = closed & (np.cumsum(~closed) > 0)
            sample = first_closed(closed, block.first_sample)
            if sample is not None and (not pinch.contacts or sample < pinch.end):
                pinch.strips[finger] = sample

    def _end(self, sample: int, why: str) -> list[Event]:
        pinch, self._pinch = self._pinch, None
        if pinch is None or not pinch.contacts:
            return []
        events: list[Event] = []
        if len(pinch.estimates) < len(self._models) and not pinch.refused:
            events.append(self._refuse(pinch, why or "the closing ended before the window"))
        self._number += 1
        strips = sorted(pinch.strips.items(), key=lambda item: item[1])
        done = PinchDone(
            number=self._number,
            armed=pinch.armed,
            end=sample,
            epoch=pinch.epoch,
            contacts=tuple(pinch.contacts),
            strips=tuple((f, s) for f, s in strips),
            estimates=tuple(pinch.estimates),
            cases=tuple(self._hindsight(pinch, e) for e in pinch.estimates),
            refused=pinch.refused,
        )
        self.ledger.close(done)
        events.append(done)
        return events
