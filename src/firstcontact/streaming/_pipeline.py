"""Samples in, contacts and estimates out: the objects of the study, fed block by block."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from firstcontact.contact import ClosingBegan, ClosingEnded, Closings, ClosingSamples, Detector
from firstcontact.core import Block, Calibration, InputError, Layout, is_same_rate, merge_blocks
from firstcontact.device import TransportDelay
from firstcontact.signal import ContactWindow, WindowStream, samples_in
from firstcontact.streaming._closing import OpenClosing, Strips
from firstcontact.streaming._events import Armed, Estimated, Event, PinchDone, Refused, Touched
from firstcontact.streaming._ledger import Ledger
from firstcontact.streaming._models import ModelWithInterval
from firstcontact.streaming._running import RunningAnswers

if TYPE_CHECKING:
    from firstcontact.models import InContextModel

#: A pinch is over so long after its first contact (or after the longest window, if
#: that is longer), s: all offsets are shorter.
AFTER = 0.2
#: Where nothing is due, samples are worked on in lots of this length, s: each wakes a core that
#: has grown cold, and a page draws no oftener.
IDLE = 0.024
#: Without noise floors an epoch is one closing: a longer one is a stream of several, s.
LONGEST_EPOCH = 10.0

_log = logging.getLogger(__name__)


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
        epoch. A warning is logged where an epoch is longer than any closing, as a stream's is.
    clock
        Gives the host's time, s.
    anytime
        A model that answers each millisecond until the second contact; None without.
    delay
        Of the source's own filter, s: counted in all that is said to come after a contact.
    real_time
        Whether samples come as fast as they were taken. Where not, no estimate is said to be in
        time or too late.

    Attributes
    ----------
    radius
        Of what is pinched next, m, as somebody tells it: infinite for a flat thing, NaN where
        nobody does. It holds from the next closing on.

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
        anytime: InContextModel | None = None,
        delay: float = 0.0,
        real_time: bool = True,
    ) -> None:
        if anytime is not None and not is_same_rate(layout.rate, anytime.rate):
            raise InputError(
                f"the any-time model takes samples at {anytime.rate:g} Hz but these come at "
                f"{layout.rate:g} Hz: set the device to that rate, or name a folder with a model "
                "of windows at this one"
            )
        for entry in models:
            spec = entry.model.spec
            spec.require_rate(layout.rate)
            if spec.channels != 1:
                raise InputError(
                    f"the model takes {spec.channels} channels and live windows have the one of "
                    "the finger that touched: train a model on these"
                )
        self.layout = layout
        #: Name of what finds contacts.
        self.detector = detector.name
        self.ledger = Ledger(layout.rate, delay)
        self._delay = delay
        self._transport = TransportDelay(layout.rate) if real_time else None
        self.radius = math.nan
        self._models = {a.model.spec.duration: a for a in models}
        if len(self._models) < len(models):
            raise InputError(
                "two models are for windows of the same length: give one of each length"
            )
        self._anytime = anytime
        self._clock = clock
        self._rehearse(Closings(layout, detector))
        self._closings = Closings(layout, detector, calibration)
        longest = max((a.model.spec.duration for a in models), default=0.0)
        self._after = samples_in(max(AFTER, 1.5 * longest), layout.rate)
        self._idle = samples_in(IDLE, layout.rate)
        self._strips = Strips(layout)
        self._pinch: OpenClosing | None = None
        self._number = 0
        self._waiting: list[Block] = []
        self._waiting_samples = 0
        self._lot = self._idle  # samples that are worked on together
        self._epoch_began: tuple[int, int] | None = None  # epoch and its first sample
        self._has_warned = self._closings.has_floors

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
        if self._transport is not None:
            self._transport.add(block, host)
        self._waiting.append(block)
        self._waiting_samples += len(block.data)
        if self._waiting_samples >= self._lot:
            yield from self._work(host)

    @property
    def answers_at_any_time(self) -> bool:
        """Whether there is an any-time model."""
        return self._anytime is not None

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
        scale = np.array([c.scale for c in self.layout.column_channels])
        offset = np.array([c.offset for c in self.layout.column_channels])
        windows, running = WindowStream(self.layout, tuple(self._models)), self._running()
        for stage in closings.update(Block(volts / scale + offset)):
            if isinstance(stage, ClosingSamples):
                for window in windows.update(stage.block, stage.contacts[:1]):
                    self._models[window.duration].model.predict_one(window.samples)
                if running is not None:
                    running.update(stage.block, stage.contacts[:1], 0.0)

    def _running(self) -> RunningAnswers | None:
        if self._anytime is None:
            return None
        return RunningAnswers(self._anytime, self.layout, self._clock, self._delay, self.radius)

    def _work(self, host: float) -> Iterator[Event]:
        began = self._clock()
        (block,) = merge_blocks(self._waiting)
        self._warn_of_long_epoch(block)
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
        answer = None if self._pinch is None else self._pinch.due
        self._lot = min(n for n in (self._idle, self._closings.due, answer) if n is not None)
        self.ledger.worked(self._clock() - began, len(block.data))

    def _warn_of_long_epoch(self, block: Block) -> None:
        """Say once that only the first closing of an epoch can be found."""
        if self._has_warned:
            return
        if self._epoch_began is None or self._epoch_began[0] != block.epoch:
            self._epoch_began = block.epoch, block.first_sample
        seconds = (block.end - self._epoch_began[1]) / self.layout.rate
        if seconds > LONGEST_EPOCH:
            self._has_warned = True
            _log.warning(
                "this stream has gone on for %.0f s and the pipeline has no calibration with noise "
                "floors: it looks for one closing in each epoch and misses all others. Pass "
                "calibration, such as that of firstcontact.device._noise_floor.measure_noise",
                seconds,
            )

    def _begin(self, stage: ClosingBegan) -> None:
        windows = WindowStream(self.layout, tuple(self._models))
        self._pinch = OpenClosing(
            stage.sample, stage.epoch, windows, len(self._models), self._running()
        )
        self._strips.begin()

    def _go_on(self, went: ClosingSamples, host: float) -> list[Event]:
        pinch = self._pinch
        if pinch is None:
            return []
        last = went.block.end - 1
        transport = 0.0 if self._transport is None else self._transport.of(last, host)
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
        self._strips.watch(went.block, pinch.end if pinch.contacts else None)
        if pinch.running is not None:
            for known, event in pinch.running.update(went.block, pinch.contacts, host, transport):
                self.ledger.tell(event)
                events.append((known, event))
        if pinch.asked > 0:
            refused = pinch.windows.refused
            for window in pinch.windows.update(went.block, told):
                # A short window can be whole before its contact is decided.
                known = max(window.complete, window.contact.decided)
                waited = (last - known) / self.layout.rate + self._delay
                estimate = self._estimate(pinch, window, known, host, waited, transport)
                events.append((known, estimate))
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
        self,
        pinch: OpenClosing,
        window: ContactWindow,
        known: int,
        host: float,
        waited: float,
        transport: float,
    ) -> Estimated | Refused:
        entry = self._models[window.duration]
        try:
            value = entry.model.predict_one(window.samples)
            low, high, level = entry.bounds(value, window.samples)
        except InputError as error:
            return self._refuse(pinch, str(error))
        if not (math.isfinite(value) and math.isfinite(low) and math.isfinite(high)):
            return self._refuse(pinch, "the model's answer is no finite number")
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
            used=all(c.decided > known for c in pinch.contacts[1:]),
            host=now,
            compute=now - host,
            waited=waited,
            transport=transport,
        )
        pinch.estimates.append(estimate)
        self.ledger.add(estimate)
        return estimate

    def _refuse(self, pinch: OpenClosing, why: str) -> Refused:
        pinch.refused = why
        return Refused(pinch.contacts[0], why, pinch.epoch)

    def _end(self, sample: int, why: str) -> list[Event]:
        pinch, self._pinch = self._pinch, None
        if pinch is None or not pinch.contacts:
            return []
        events: list[Event] = []
        running = pinch.running
        answers = () if running is None else tuple(running.answers)
        settled = running is None or bool(answers) or bool(running.refused)
        why = why or "the closing ended before the window"
        if running is not None:
            events += running.finish(sample, pinch.epoch, why)
        if not pinch.refused and (len(pinch.estimates) < len(self._models) or not settled):
            events.append(self._refuse(pinch, why))
        self._number += 1
        done = PinchDone(
            number=self._number,
            armed=pinch.armed,
            end=sample,
            epoch=pinch.epoch,
            contacts=tuple(pinch.contacts),
            strips=self._strips.closed,
            estimates=tuple(pinch.estimates),
            rate=self.layout.rate,
            refused=pinch.refused or self._unanswered(pinch),
            answers=answers,
            real_time=self._transport is not None,
        )
        self.ledger.close(done)
        events.append(done)
        return events

    @staticmethod
    def _unanswered(pinch: OpenClosing) -> str:
        """Why there is no answer of any model, "" where there is one."""
        running = pinch.running
        if running is None or running.answers or pinch.estimates:
            return ""
        return running.refused
