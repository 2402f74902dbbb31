"""Live pipeline: samples in, contacts and estimates out, block by block.

The source decides the block size. The pipeline joins blocks until an event is possible.
"""

from __future__ import annotations

import logging
import math
import time
from bisect import bisect_right
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from firstcontact.chain import Chain, ChainEvent, EventKind, Flag, Reason, build_image
from firstcontact.chain.image import DetectorKind
from firstcontact.chain.stream import Predict
from firstcontact.contact import Detector
from firstcontact.contact.closing_start import RecordedClosing, recorded_closings
from firstcontact.core import (
    Block,
    Calibration,
    ClosingSpeed,
    Contact,
    Estimate,
    InputError,
    Layout,
    merge_blocks,
)
from firstcontact.core.physics import radius_text
from firstcontact.device.clock import TransportDelay
from firstcontact.models import Hints
from firstcontact.models.anytime import Predictor
from firstcontact.recording import Recording
from firstcontact.signal import samples_in
from firstcontact.streaming._closing import OpenClosing, Strips
from firstcontact.streaming._delays import delay_cause, processor_wait
from firstcontact.streaming.events import (
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    Event,
    NoEstimate,
    PinchDone,
)
from firstcontact.streaming.ledger import Ledger

#: Time after the first contact at which a pinch is over, s, or 1.5 times the last moment of the
#: model if that is longer: all offsets between the contacts are shorter.
AFTER = 0.2
#: Shortest and longest groups in which samples are processed while no event is due, s. Each group
#: wakes an idle core. The motor starts 0.1 s or more before a contact.
IDLE = 0.018, 0.036
#: Longest closing, s. Without noise floors, a longer epoch contains several closings.
LONGEST_EPOCH = 10.0
#: Number of motor starts in a row under load after which a warning is logged. A hand that adjusts
#: its grip on a held object makes some, too.
REFUSED = 6

#: Reasons for a closing without an estimate.
REASONS = {
    Reason.DONE: "the closing ended before the first estimate",
    Reason.RESTED: "the closing ended before the first estimate",
    Reason.LOST: "samples were lost",
    Reason.STREAM_ENDED: "the stream ended",
    Reason.TOO_EARLY: "there is too little signal before the contact",
    Reason.NO_SIGNAL: "the piezo gives no signal",
    Reason.SECOND_TOUCHED: "the second finger touched before there was an estimate",
    Reason.NOT_FINITE: "the model's prediction is not a finite number",
}

#: Function that returns the closing speed before a contact. It takes the contact's sample, epoch,
#: and time on the host's clock, s (NaN if unknown).
MeasureSpeed = Callable[[int, int, float], ClosingSpeed | None]

_log = logging.getLogger("firstcontact.streaming")


class Pipeline:
    """Live pipeline that turns blocks of samples into contacts and stiffness estimates.

    For each closing of the hand, the results equal those of the same detector and model offline, on
    the same samples of a recording. They do not depend on the sizes of the blocks.

    Parameters
    ----------
    layout, detector
        Columns and sampling rate of the samples, and a fitted or loaded contact detector.
    predictor
        Model that predicts the stiffness; None to detect contacts without estimates.
    calibration
        Noise floors of the fingers. Without them only the first closing of each epoch is detected.
    clock
        Function that returns the time by this computer's clock, s.
    delay
        Delay of the source's own filter, s. It is part of ``available`` in estimates.
    real_time
        True if samples arrive in real time, as from a device. Otherwise estimates are not rated as
        in time or too late.
    resettles
        True to measure the noise of the running motor (the steady state) again when it becomes
        quieter, and to withdraw false contacts. False to measure once a closing, as devices do.
    """

    def __init__(
        self,
        layout: Layout,
        detector: Detector,
        predictor: Predictor | None = None,
        calibration: Calibration | None = None,
        clock: Callable[[], float] = time.monotonic,
        delay: float = 0.0,
        real_time: bool = True,
        resettles: bool = True,
    ) -> None:
        if predictor is not None:
            predictor.check(layout)
        self.layout = layout
        #: Name of the detector.
        self.detector = detector.name
        #: Model that predicts the stiffness; None to detect contacts without estimates.
        self.predictor = predictor
        self.ledger = Ledger(layout.rate, delay)
        #: True if samples arrive in real time.
        self.real_time = real_time
        #: Radius of curvature of the object, m: infinite for a flat one, NaN if unknown.
        self.radius = math.nan
        #: True if all estimates are out of range, because the signals are not in the model's unit.
        self.is_foreign = False
        #: Function that returns the closing speed before a contact; None if nothing measures it.
        self.measure_speed: MeasureSpeed | None = None
        #: Longest time between two polls for samples since the first contact, s.
        self.poll_gap = 0.0
        self._queued = 0.0  # wait for a processor until the last block before a contact, s
        self._thread_start = 0.0  # time of this thread at the start of the work on a block, s
        self._delay = delay
        self._resettles = resettles
        self._transport = TransportDelay(layout.rate) if real_time else None
        self._clock = clock
        longest = 0.0 if predictor is None else predictor.prediction_times[-1]
        constants = detector.chain_constants(layout.rate)
        self._image = build_image(
            layout.rate,
            constants,
            None if predictor is None else predictor.chain_constants(),
            after=max(AFTER, 1.5 * longest),
        )
        self._plugin: Any = detector if constants.kind is DetectorKind.PYTHON else None
        self._fingers = layout.vibration_fingers
        self._idle = samples_in(IDLE[0], layout.rate)
        self._strips = Strips(layout)
        self._pinch: OpenClosing | None = None
        self._number = 0
        self._waiting: list[Block] = []
        self._waiting_samples = 0
        self._lot = self._idle  # samples that are processed together
        self._closings: tuple[RecordedClosing, ...] = ()
        self._run = 0  # number of the waiting samples' epoch, or of their recorded closing
        self._block, self._host, self._now = Block(np.zeros((0, layout.width))), 0.0, 0.0
        #: First contacts in the samples that the chain processes: closing speed and radius.
        self._touched: dict[int, tuple[ClosingSpeed | None, float]] = {}
        self._epoch_start = -1, 0  # epoch and its first sample
        self._has_warned = False  # of the length of an epoch
        self._has_warned_of_load = False
        self.calibrate(calibration)

    def calibrate(self, calibration: Calibration | None) -> None:
        """Set the noise floors from a calibration. Call this only before the first block."""
        self._chain = Chain(
            self._image,
            self.layout,
            calibration,
            detector=self._plugin,
            predict=None if self.predictor is None else _called(self.predictor),
            contact=self._touch,
            keeps_first_state=not self._resettles,
        )
        self._has_warned = self._chain.has_floors

    def follow(self, recording: Recording) -> None:
        """Begin closings where a recording marks its pinches, as offline functions do.

        With noise floors, closings are detected instead. Call this before the first block, and
        after :meth:`calibrate`.
        """
        if recording.pinches and not self._chain.has_floors:
            self._closings = recorded_closings(recording, self.layout.rate)
            self._has_warned = True

    def _parts(self, block: Block) -> Iterator[tuple[int, Block]]:
        """Yield the parts of a block that lie within closings, with the number of the closing.

        Without marked closings it is the whole block, with its epoch.
        """
        if not self._closings:
            yield block.epoch, block
        begin, stop = (block.epoch, block.first_sample), (block.epoch, block.end)
        place = bisect_right(self._closings, begin, key=lambda c: (c.epoch, c.end))
        for run, closing in enumerate(self._closings[place : place + len(block.data)], place):
            if (closing.epoch, closing.start) >= stop:
                break
            first, end = max(closing.start, block.first_sample), min(closing.end, block.end)
            data = block.data[first - block.first_sample : end - block.first_sample]
            yield run, Block(data, first, block.epoch)

    def update(self, block: Block, host: float) -> Iterator[Event]:
        """Process the next block. Yield the events that are now due, in order.

        ``host`` is the time by this computer's clock, s, when the block's last byte had been read.
        Exhaust the iterator before you pass the next block.
        """
        waiting = self._waiting
        if waiting and (waiting[-1].end, waiting[-1].epoch) != (block.first_sample, block.epoch):
            yield from self._work(host)
        if self._transport is not None:
            self._transport.add(block, host)
        for run, part in self._parts(block):
            if self._waiting and (self._waiting[-1].end, self._run) != (part.first_sample, run):
                yield from self._work(host)
            self._run = run
            self._waiting.append(part)
            self._waiting_samples += len(part.data)
            if self._waiting_samples >= self._lot:
                yield from self._work(host)

    def set_batch(self, seconds: float) -> None:
        """Process samples in batches of ``seconds`` (0.018 to 0.036 s) while no event is due."""
        self._idle = samples_in(min(max(seconds, IDLE[0]), IDLE[1]), self.layout.rate)

    @property
    def is_closing(self) -> bool:
        """True while a closing (one movement of the hand around an object) is in progress."""
        return self._chain.runs

    @property
    def is_predicting(self) -> bool:
        """True from the first contact of a closing until its last estimate."""
        pinch = self._pinch
        if pinch is None or self.predictor is None:
            return False
        return bool(pinch.contacts) and not pinch.is_settled

    @property
    def is_urgent(self) -> bool:
        """True while contacts or estimates of a closing are due.

        Without noise floors a closing may be as long as the stream, so only estimates count.
        """
        return self.is_predicting or (self._chain.has_floors and self._chain.is_open)

    @property
    def due(self) -> int:
        """Number of further samples until the next event is possible, at least 1."""
        return max(1, self._lot - self._waiting_samples)

    def finish(self) -> list[Event]:
        """Return the events of the last pinch that remain. Call this after the last block."""
        events = list(self._work(self._clock())) if self._waiting else []
        for event in self._chain.finish():
            events += self._live(event)
        return events

    def _work(self, host: float) -> Iterator[Event]:
        start, self._thread_start = self._clock(), time.thread_time()
        (block,) = merge_blocks(self._waiting)
        self._warn_of_long_epoch(block)
        self._waiting = []
        self._waiting_samples = 0
        self._block, self._host = block, host
        events = self._chain.take(Block(block.data, block.first_sample, self._run))
        self._now = self._clock()
        for event in events:
            yield from self._live(event)
        self._watch_strips(block.end)
        self._touched.clear()
        if self._pinch is None:
            self._warn_of_load()
        else:
            self._measure_speed(self._pinch)
        self._lot = self._chain.due(self._idle)
        if self._pinch is not None and self.real_time and not self.is_predicting:
            self._queued, self.poll_gap = processor_wait(), 0.0
        self.ledger.worked(self._clock() - start, len(block.data))

    def _touch(self, sample: int) -> tuple[float, float, float]:
        """Return closing speed, m/s, its relative error, and radius, m, of a first contact.

        A speed of 0 and a radius of NaN stand for unknown.
        """
        speed = None
        if self.predictor is not None and self.predictor.uses_speed:
            speed = self._ask_speed(sample, self._block.epoch)
        self._touched[sample] = speed, self.radius
        if speed is None:
            return 0.0, 0.0, self.radius
        return speed.speed, speed.error / speed.speed, self.radius

    def _warn_of_long_epoch(self, block: Block) -> None:
        """Warn once that, without noise floors, only the first closing of an epoch is detected."""
        if self._epoch_start[0] != block.epoch:
            self._epoch_start = block.epoch, block.first_sample
        seconds = (block.end - self._epoch_start[1]) / self.layout.rate
        if seconds > LONGEST_EPOCH and not self._has_warned:
            self._has_warned = True
            _log.warning(
                "this stream has run for %.0f s without noise floors, so only the first closing "
                "of each epoch is detected: pass a calibration from firstcontact.calibrate",
                seconds,
            )

    def _warn_of_load(self) -> None:
        """Warn once that no closing is detected, because a force stays high."""
        if self._has_warned_of_load or self._chain.refused < REFUSED:
            return
        self._has_warned_of_load = True
        _log.warning(
            "the motor has started %d times in a row while a force was high, as if the hand held "
            "an object, so no closing was detected: if it holds none, start the session again",
            REFUSED,
        )

    def _live(self, e: ChainEvent) -> Iterator[Event]:
        """Yield the live events for one event that the C chain reported."""
        if e.kind == EventKind.CLOSING_BEGAN:
            self._pinch = OpenClosing(e.sample, self._block.epoch, e.sample)
            self._strips.begin()
            self.ledger.closings += 1
            yield ClosingStart(e.sample, self._block.epoch)
            return
        pinch = self._pinch
        if pinch is None:
            return
        self._watch_strips(e.sample if e.kind == EventKind.CLOSING_ENDED else e.known)
        match e.kind:
            case EventKind.CONTACT_FOUND:
                yield from self._add_contact(pinch, e)
            case EventKind.CONTACT_WITHDRAWN:
                _log.info("the contact at sample %d is withdrawn", pinch.contacts[0].sample)
                yield ContactWithdrawn(pinch.contacts[0], e.known, pinch.epoch)
                pinch.withdraw()
            case EventKind.ESTIMATED if e.flags & Flag.FINAL:
                yield self._settle(pinch, self._last_used(e), e.known, "")
            case EventKind.ESTIMATED:
                yield self._add_estimate(pinch, e)
            case EventKind.NOT_ESTIMATED:
                yield self._settle(pinch, -1, e.known, REASONS[Reason(e.reason)])
            case EventKind.CLOSING_ENDED:
                yield from self._end(pinch, e)

    def _add_contact(self, pinch: OpenClosing, e: ChainEvent) -> Iterator[Event]:
        contact = Contact(self._fingers[e.channel], e.sample, e.known)
        is_first = not pinch.contacts
        pinch.contacts.append(contact)
        if is_first:
            pinch.closing_speed, radius = self._touched[e.sample]
            pinch.shape = radius_text(radius)
            pinch.unmeasured = contact if pinch.closing_speed is None else None
        yield ContactEvent(contact, is_first, pinch.epoch, self._now)

    def _last_used(self, e: ChainEvent) -> int:
        """Return the number of the last sample that an estimate uses."""
        assert self.predictor is not None
        return e.sample + e.samples + self.predictor.lookahead - 1

    def _add_estimate(self, pinch: OpenClosing, e: ChainEvent) -> Estimate:
        assert self.predictor is not None
        last = self._last_used(e)
        first, block, rate = pinch.contacts[0], self._block, self.layout.rate
        complete = max(last, first.decided)
        waited = (block.end - 1 - complete) / rate + self._delay
        transport = 0.0
        if self._transport is not None:
            transport = self._transport.delay(block.end - 1, self._host)
        compute = self._now - self._host
        if not pinch.made:
            pinch.stalled = compute - (time.thread_time() - self._thread_start)
        estimate = Estimate(
            value=e.value,
            low=e.low,
            high=e.high,
            level=self.predictor.level or 0.0,
            elapsed=e.samples / rate,
            available=(complete - first.sample) / rate + waited + transport + compute,
            out_of_range=bool(e.flags & Flag.OUT_OF_RANGE) or self.is_foreign,
            model=self.predictor.name,
            contact=first,
            complete=complete,
            epoch=pinch.epoch,
            host=self._now,
            compute=compute,
            waited=waited,
            transport=transport,
            shape=pinch.shape,
            quantity=self.predictor.quantity.name,
            half_width=None if math.isnan(e.half_width) else e.half_width,
        )
        pinch.made.append((last, estimate))
        self.ledger.add(estimate)
        return estimate

    def _settle(
        self, pinch: OpenClosing, last: int, complete: int, reason: str
    ) -> Estimate | NoEstimate:
        """Return the final estimate from samples up to ``last``, or a report that there is none."""
        final = pinch.settle(last, self.layout.rate, real_time=self.real_time)
        if self.real_time:
            pinch.queued = processor_wait() - self._queued
            pinch.stalled = max(pinch.stalled, self.poll_gap)
        pinch.reason = reason if final is None else ""
        return final or NoEstimate(pinch.contacts[0], reason, complete, pinch.epoch)

    def _watch_strips(self, stop: int) -> None:
        """Process the strips' samples of this closing up to the sample number ``stop``."""
        pinch, block = self._pinch, self._block
        if pinch is None or pinch.epoch != block.epoch:
            return
        start, pinch.heard = max(pinch.heard, block.first_sample), max(pinch.heard, stop)
        if stop > start and self._strips.exist:
            data = block.data[start - block.first_sample : stop - block.first_sample]
            self._strips.watch(Block(data, start, block.epoch))

    def _ask_speed(self, sample: int, epoch: int) -> ClosingSpeed | None:
        """Return the closing speed measured before a contact, or None. It may take milliseconds."""
        if self.measure_speed is None:
            return None
        host = math.nan if self._transport is None else self._transport.host_time(sample)
        return self.measure_speed(sample, epoch, host)

    def _measure_speed(self, pinch: OpenClosing) -> None:
        contact, pinch.unmeasured = pinch.unmeasured, None
        if contact is not None:
            pinch.closing_speed = self._ask_speed(contact.sample, pinch.epoch)

    def _end(self, pinch: OpenClosing, e: ChainEvent) -> Iterator[Event]:
        self._pinch = None
        if not pinch.contacts:
            return
        self._measure_speed(pinch)
        self._number += 1
        first, second = pinch.contacts[0], pinch.second
        offset = None if second is None else (second.sample - first.sample) / self.layout.rate
        cause = ""
        if self.real_time and pinch.made:
            cause = delay_cause(pinch.made[0][1], offset, pinch.queued, pinch.stalled)
        if cause:
            _log.info("the estimates of pinch %d came too late: %s", self._number, cause)
        finished_pinch = PinchDone(
            number=self._number,
            start=pinch.start,
            end=e.sample,
            epoch=pinch.epoch,
            contacts=tuple(pinch.contacts),
            strips=self._strips.contacts,
            offset=offset,
            estimates=tuple(estimate for _, estimate in pinch.made),
            reason=pinch.reason,
            real_time=self.real_time,
            closing_speed=pinch.closing_speed,
            delay_cause=cause,
        )
        self.ledger.close(finished_pinch)
        yield finished_pinch


def _called(predictor: Predictor) -> Predict:
    """Return the function through which the compiled chain calls a predictor in Python."""

    def predict(
        signal: bytes, lead: int, samples: int, finger: int, *hints: float
    ) -> tuple[float, float, float, float, float, bool] | None:
        try:
            return predictor.predict(np.frombuffer(signal), samples, finger, Hints(*hints))
        except InputError as error:
            _log.info("no prediction: %s", error)
            return math.nan, math.nan, math.nan, math.nan, math.nan, False

    return predict
