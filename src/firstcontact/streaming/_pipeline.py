"""Live pipeline: samples in, contacts and estimates out, block by block."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterator

import numpy as np

from firstcontact.contact import (
    ClosingBegan,
    ClosingEnded,
    Closings,
    ClosingSamples,
    Detector,
)
from firstcontact.core import (
    Block,
    Calibration,
    ClosingSpeed,
    Contact,
    Estimate,
    Layout,
    merge_blocks,
)
from firstcontact.device import TransportDelay
from firstcontact.signal import samples_in
from firstcontact.streaming._closing import OpenClosing, Strips
from firstcontact.streaming._estimates import ClosingEstimates
from firstcontact.streaming._events import (
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    Event,
    PinchDone,
)
from firstcontact.streaming._ledger import Ledger
from firstcontact.streaming._predictors import Predictor

#: Time after the first contact at which a pinch is over, s, or 1.5 times the last moment of the
#: model if that is longer: all offsets between the contacts are shorter.
AFTER = 0.2
#: Length of the groups in which samples are processed while no event is due, s. Each group wakes an
#: idle core, and the page does not draw more often than that.
IDLE = 0.024
#: Time between predictions for an artificial contact while a closing waits for its first one, s.
#: Otherwise the model leaves the processor's caches within a few milliseconds.
WARM = 0.005
#: Longest closing, s. Without noise floors, a longer epoch contains several closings.
LONGEST_EPOCH = 10.0
#: Number of motor starts in a row under load after which a warning is logged. A hand that adjusts
#: its grip on a held object makes some, too.
REFUSED = 6

#: Function that returns the closing speed before a contact. It takes the contact's sample, epoch,
#: and time on the host's clock, s (NaN if unknown).
MeasureSpeed = Callable[[int, int, float], ClosingSpeed | None]

_log = logging.getLogger(__name__)


class Pipeline:
    """Live pipeline: detects contacts and estimates stiffness.

    The contacts and estimates of a closing are those that the same detector and model give offline
    for the same closing, cut out of a recording. They do not depend on the sizes of the blocks.

    Parameters
    ----------
    layout
        Columns of the blocks.
    detector
        Fitted or loaded detector.
    predictor
        Model that predicts; see :func:`firstcontact.streaming.live_predictor`. None to detect
        contacts without estimates.
    calibration
        Noise floors of the fingers. Without them a closing begins with each epoch, and a warning is
        logged if an epoch is longer than any closing. With them, a warning is logged if a force
        that stays high hides the closings.
    clock
        Clock of the host, s.
    delay
        Delay of the source's own filter, s. All times after a contact include it.
    real_time
        True if samples come as fast as they were taken. Otherwise estimates are not rated as in
        time or too late.
    resettles
        See :class:`firstcontact.contact.ContactListener`.

    Attributes
    ----------
    radius
        Radius of the object in the next closings, m: infinite for a flat object, NaN if unknown.
    measure_speed
        Function that returns the closing speed before a contact; None if nothing measures the
        speed.

    Raises
    ------
    InputError
        The detector or the model does not fit this layout.

    Notes
    -----
    The pipeline first processes one simulated pinch, so that the first real one does not wait for
    lazy loading.
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
        #: Model that predicts; None to detect contacts without estimates.
        self.predictor = predictor
        self.ledger = Ledger(layout.rate, delay)
        self.radius = math.nan
        self.measure_speed: MeasureSpeed | None = None
        self._delay = delay
        self._resettles = resettles
        self._transport = TransportDelay(layout.rate) if real_time else None
        self._clock = clock
        self._rehearse(Closings(layout, detector))
        self._detector = detector
        self.calibrate(calibration)
        longest = 0.0 if predictor is None else predictor.moments[-1]
        self._after = samples_in(max(AFTER, 1.5 * longest), layout.rate)
        self._idle = samples_in(IDLE, layout.rate)
        self._strips = Strips(layout)
        self._pinch: OpenClosing | None = None
        self._number = 0
        self._waiting: list[Block] = []
        self._waiting_samples = 0
        self._every = samples_in(WARM, layout.rate)
        self._warmed = 0  # sample of the last prediction for a made-up contact
        self._lot = self._idle  # samples that are processed together
        self._epoch_start: tuple[int, int] | None = None  # epoch and its first sample

    def calibrate(self, calibration: Calibration | None) -> None:
        """Set the noise floors. Call it only before the first block."""
        self._closings = Closings(
            self.layout, self._detector, calibration, resettles=self._resettles
        )
        self._has_warned = self._closings.has_floors
        self._has_warned_of_load = False

    def update(self, block: Block, host: float) -> Iterator[Event]:
        """Yield the events of the next block in order, without delay.

        Exhaust the iterator before you pass the next block.

        Parameters
        ----------
        block
            Samples.
        host
            Time at which the block's last byte had been read, on the host's clock, s.
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
    def real_time(self) -> bool:
        """True if samples come as fast as they were taken."""
        return self._transport is not None

    @property
    def is_closing(self) -> bool:
        """True while a closing is in progress."""
        return self._closings.open

    @property
    def is_predicting(self) -> bool:
        """True from the first contact of a closing until its last estimate."""
        pinch = self._pinch
        return pinch is not None and pinch.estimates is not None and pinch.estimates.due is not None

    @property
    def due(self) -> int:
        """Number of further samples until the next event is possible, at least 1."""
        return max(1, self._lot - self._waiting_samples)

    def finish(self) -> list[Event]:
        """Return the remaining events of the last pinch. Call this once the stream has ended."""
        events = list(self._work(self._clock())) if self._waiting else []
        if self._pinch is not None:
            events += self._end(self._closings.end, "the stream ended")
        return events

    def _rehearse(self, closings: Closings) -> None:
        """Detect and predict once, for a simulated contact."""
        rate = self.layout.rate
        t = np.arange(samples_in(0.3, rate)) / rate - 0.15
        noise = np.random.default_rng(0).standard_normal((len(t), self.layout.width))
        ring = np.where(t > 0, np.exp(-t.clip(0) / 0.01) * np.sin(900.0 * t), 0.0)
        volts = 0.005 * noise + 0.5 * ring[:, None]
        scale = np.array([c.scale for c in self.layout.column_channels])
        offset = np.array([c.offset for c in self.layout.column_channels])
        stream = None if self.predictor is None else self.predictor.start(self.layout)
        contact = None
        for stage in closings.update(Block(volts / scale + offset)):
            if isinstance(stage, ClosingSamples) and stream is not None:
                first = stage.contacts[0] if stage.contacts and contact is None else None
                contact = contact or first
                list(stream.update(stage.block, first))

    def _work(self, host: float) -> Iterator[Event]:
        start = self._clock()
        (block,) = merge_blocks(self._waiting)
        self._warn_of_long_epoch(block)
        self._waiting = []
        self._waiting_samples = 0
        for stage in self._closings.update(block):
            match stage:
                case ClosingBegan():
                    self._begin(stage)
                    yield ClosingStart(stage.sample, stage.epoch)
                case ClosingSamples():
                    yield from self._go_on(stage, host)
                    if stage.withdrawn is not None:
                        yield from self._withdraw(stage.withdrawn, stage.block)
                case ClosingEnded():
                    yield from self._end(
                        stage.sample, "" if stage.is_complete else "samples were lost"
                    )
        self._warn_of_load()
        pinch = self._pinch
        if pinch is not None:
            self._measure_speed(pinch)
        due = None if pinch is None or pinch.estimates is None else pinch.estimates.due
        self._lot = min(n for n in (self._idle, self._closings.due, due) if n is not None)
        if pinch is not None and pinch.estimates is not None:
            self._prepare(pinch, pinch.estimates)
        self.ledger.worked(self._clock() - start, len(block.data))

    def _prepare(self, pinch: OpenClosing, estimates: ClosingEstimates) -> None:
        """Prepare the next estimate in the pause before the next block."""
        estimates.prepare()
        if self._transport is None or self.predictor is None or pinch.contacts:
            return
        if abs(self._closings.end - self._warmed) >= self._every:  # numbers restart in an epoch
            self._warmed = self._closings.end
            self.predictor.warm()

    def _warn_of_long_epoch(self, block: Block) -> None:
        """Warn once that, without noise floors, only the first closing of an epoch is detected."""
        if self._has_warned:
            return
        if self._epoch_start is None or self._epoch_start[0] != block.epoch:
            self._epoch_start = block.epoch, block.first_sample
        seconds = (block.end - self._epoch_start[1]) / self.layout.rate
        if seconds > LONGEST_EPOCH:
            self._has_warned = True
            _log.warning(
                "this stream has run for %.0f s without noise floors, so only the first closing "
                "of each epoch is detected: pass a calibration from firstcontact.calibrate",
                seconds,
            )

    def _warn_of_load(self) -> None:
        """Warn once that a force that stays high hides all closings."""
        if self._has_warned_of_load or self._closings.refused < REFUSED:
            return
        self._has_warned_of_load = True
        _log.warning(
            "the motor has started %d times in a row while a force was high, as if the hand held "
            "an object, so no closing was detected: if it holds none, start the session again",
            REFUSED,
        )

    def _begin(self, stage: ClosingBegan) -> None:
        estimates = None
        if self.predictor is not None:
            estimates = ClosingEstimates(
                self.predictor,
                self.layout,
                self._clock,
                self._delay,
                self.radius,
                real_time=self._transport is not None,
            )
        self._pinch = OpenClosing(stage.sample, stage.epoch, estimates)
        self._strips.begin()

    def _go_on(self, stage: ClosingSamples, host: float) -> list[Event]:
        pinch = self._pinch
        if pinch is None:
            return []
        block = stage.block
        transport = 0.0 if self._transport is None else self._transport.delay(block.end - 1, host)
        # Each event with the sample with which it was known: block sizes do not change the order.
        events: list[tuple[int, Event]] = []
        for contact in stage.contacts:
            if not pinch.contacts:
                pinch.end = contact.sample + self._after
            elif contact.decided >= pinch.end:
                continue
            is_first = not pinch.contacts
            pinch.contacts.append(contact)
            if is_first:
                pinch.unmeasured = contact
                if self.predictor is not None and self.predictor.uses_speed:
                    self._measure_speed(pinch)
            event = ContactEvent(contact, is_first, pinch.epoch, self._clock())
            events.append((contact.decided, event))
        if pinch.estimates is not None:
            for sample, prediction in pinch.estimates.update(
                block, pinch.contacts, host, transport
            ):
                events.append((sample, prediction))
                if isinstance(prediction, Estimate) and not prediction.final:
                    self.ledger.add(prediction)
        self._strips.watch(block, pinch.end if pinch.contacts else None)
        events.sort(key=lambda pair: pair[0])
        ordered = [event for _, event in events]
        if pinch.contacts and block.end >= pinch.end:
            ordered += self._end(pinch.end, "")
        return ordered

    def _measure_speed(self, pinch: OpenClosing) -> None:
        """Measure the closing speed before the first contact. This may take milliseconds."""
        contact, pinch.unmeasured = pinch.unmeasured, None
        if self.measure_speed is None or contact is None:
            return
        host = math.nan
        if self._transport is not None:
            host = self._transport.host_time(contact.sample)
        pinch.closing_speed = self.measure_speed(contact.sample, pinch.epoch, host)
        if pinch.estimates is not None:
            pinch.estimates.set_speed(pinch.closing_speed)

    def _withdraw(self, contact: Contact, block: Block) -> list[Event]:
        """Withdraw the contacts and estimates of the closing, which continues."""
        pinch = self._pinch
        if pinch is None:
            return []
        pinch.contacts, pinch.end, pinch.closing_speed = [], 0, None
        pinch.unmeasured = None
        if pinch.estimates is not None:
            pinch.estimates.withdraw()
        return [ContactWithdrawn(contact, block.end - 1, block.epoch)]

    def _end(self, sample: int, reason: str) -> list[Event]:
        pinch, self._pinch = self._pinch, None
        if pinch is None or not pinch.contacts:
            return []
        self._measure_speed(pinch)
        events: list[Event] = []
        estimates = pinch.estimates
        if estimates is not None:
            reason = reason or "the closing ended before the first estimate"
            events += estimates.finish(sample, pinch.epoch, reason)
        self._number += 1
        first, second = (*pinch.contacts, None)[:2]
        assert first is not None
        finished_pinch = PinchDone(
            number=self._number,
            start=pinch.start,
            end=sample,
            epoch=pinch.epoch,
            contacts=tuple(pinch.contacts),
            strips=self._strips.contacts,
            offset=None if second is None else (second.sample - first.sample) / self.layout.rate,
            estimates=() if estimates is None else estimates.estimates,
            reason="" if estimates is None else estimates.reason,
            real_time=self._transport is not None,
            closing_speed=pinch.closing_speed,
        )
        self.ledger.close(finished_pinch)
        events.append(finished_pinch)
        return events
