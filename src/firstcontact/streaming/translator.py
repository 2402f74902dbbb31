"""Translation of the C chain's events into live events, with the delays of estimates."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import msgspec
import numpy as np

from firstcontact.chain import ChainEvent, EventKind, Flag, Reason
from firstcontact.core import Block, ChannelKind, ClosingSpeed, Contact, Estimate, Finger, Layout
from firstcontact.core.physics import radius_text
from firstcontact.core.pinch import first_closed_sample
from firstcontact.device.clock import TransportDelay
from firstcontact.models.anytime import Predictor
from firstcontact.streaming.events import (
    ClosingStart,
    ContactEvent,
    ContactWithdrawn,
    Event,
    NoEstimate,
    PinchDone,
    judged,
)
from firstcontact.streaming.ledger import Ledger, delay_cause, processor_wait

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


@dataclass(slots=True)
class OpenClosing:
    """Closing of the hand that is in progress: its contacts, estimates and delays so far."""

    start: int
    epoch: int
    heard: int
    contacts: list[Contact] = field(default_factory=list)
    made: list[tuple[int, Estimate]] = field(default_factory=list)
    is_settled: bool = False
    reason: str = ""
    shape: str = ""
    closing_speed: ClosingSpeed | None = None
    unmeasured: Contact | None = None
    #: Wait for a processor, and longest time without running for any reason, until it settled, s.
    queued: float = 0.0
    stalled: float = 0.0

    @property
    def second(self) -> Contact | None:
        return self.contacts[1] if len(self.contacts) > 1 else None

    def withdraw(self) -> None:
        self.contacts, self.made = [], []
        self.is_settled, self.reason, self.shape = False, "", ""
        self.closing_speed = self.unmeasured = None

    def settle(self, last: int, rate: float, *, real_time: bool) -> Estimate | None:
        """Drop estimates that use samples after number ``last``. Mark the newest one as final.

        Return that estimate, or None if none is left.
        """
        self.is_settled = True
        self.made = [pair for pair in self.made if pair[0] <= last]
        if not self.made:
            return None
        used, estimate = self.made[-1]
        final = msgspec.structs.replace(estimate, final=True)
        if self.second is not None:
            offset = (self.second.sample - self.contacts[0].sample) / rate
            final = judged(final, offset, real_time=real_time)
        self.made[-1] = used, final
        self.reason = ""
        return final


class Strips:
    """Collector of true contacts, which copper strips on the fingers show.

    It stores the first contact of each strip in a closing.
    """

    def __init__(self, layout: Layout) -> None:
        columns = {f: layout.columns(ChannelKind.STRIP, f) for f in Finger}
        self._columns = {finger: places[0] for finger, places in columns.items() if places}
        #: True if the layout has a strip.
        self.exist = layout.has_strip
        self._closed: list[Contact] = []
        self._open: set[Finger] = set()

    def begin(self) -> None:
        self._closed, self._open = [], set()

    @property
    def contacts(self) -> tuple[Contact, ...]:
        return tuple(sorted(self._closed, key=lambda contact: contact.sample))

    def watch(self, block: Block) -> None:
        for finger, column in self._columns.items():
            if any(contact.finger is finger for contact in self._closed):
                continue
            values = block.data[:, column]
            if finger in self._open and not values.any():
                continue
            is_closed = values > 0
            if finger not in self._open:
                if is_closed.all():
                    continue  # held since before this closing
                self._open.add(finger)
                is_closed = is_closed & (np.cumsum(~is_closed) > 0)
            sample = first_closed_sample(is_closed, block.first_sample)
            if sample is not None:
                self._closed.append(Contact(finger, sample, sample))


class Translator:
    """Translator of the C chain's events into live events, which measures delays of estimates.

    ``delay`` is that of the source's own filter, s.
    """

    def __init__(
        self, layout: Layout, predictor: Predictor | None, delay: float, *, real_time: bool
    ) -> None:
        self.layout = layout
        self.predictor = predictor
        self.ledger = Ledger(layout.rate, delay)
        self.real_time = real_time
        #: Radius of curvature of the object, m: infinite for a flat one, NaN if unknown.
        self.radius = math.nan
        #: True if all estimates are out of range, because the signals are not in the model's unit.
        self.is_foreign = False
        #: Function that returns the closing speed before a contact; None if nothing measures it.
        self.measure_speed: MeasureSpeed | None = None
        #: Longest time between two polls for samples since the first contact, s.
        self.poll_gap = 0.0
        #: Time by this computer's clock when the chain had processed the block, s.
        self.now = 0.0
        self._queued = 0.0  # wait for a processor until the last block before a contact, s
        self._thread_start = 0.0  # time of this thread at the start of the work on a block, s
        self._delay = delay
        self._transport = TransportDelay(layout.rate) if real_time else None
        self._fingers = layout.vibration_fingers
        self._strips = Strips(layout)
        self._pinch: OpenClosing | None = None
        self._number = 0
        self._block, self._host = Block(np.zeros((0, layout.width))), 0.0
        #: First contacts in the samples that the chain processes: closing speed and radius.
        self._touched: dict[int, tuple[ClosingSpeed | None, float]] = {}

    @property
    def is_closing(self) -> bool:
        return self._pinch is not None

    @property
    def is_predicting(self) -> bool:
        """True from the first contact of a closing until the last estimate for it."""
        pinch = self._pinch
        if pinch is None or self.predictor is None:
            return False
        return bool(pinch.contacts) and not pinch.is_settled

    def arrive(self, block: Block, host: float) -> None:
        """Store the arrival time of a block, ``host`` (s), to measure how late samples arrive."""
        if self._transport is not None:
            self._transport.add(block, host)

    def begin(self, block: Block, host: float) -> None:
        """Prepare for the events of a block. Call this before the chain processes the block."""
        self._thread_start = time.thread_time()
        self._block, self._host = block, host

    def end(self) -> None:
        """Finish the work on a block. Call this after its events were translated."""
        self._watch_strips(self._block.end)
        self._touched.clear()
        if self._pinch is not None:
            self._measure_speed(self._pinch)
            if self.real_time and not self.is_predicting:
                self._queued, self.poll_gap = processor_wait(), 0.0

    def touch(self, sample: int) -> tuple[float, float, float]:
        """Return closing speed (m/s), its relative error, and object radius (m) at a first contact.

        The chain calls this method. A speed of 0 and a radius of NaN stand for unknown.
        """
        speed = None
        if self.predictor is not None and self.predictor.uses_speed:
            speed = self._ask_speed(sample, self._block.epoch)
        self._touched[sample] = speed, self.radius
        if speed is None:
            return 0.0, 0.0, self.radius
        return speed.speed, speed.error / speed.speed, self.radius

    def translate(self, e: ChainEvent) -> Iterator[Event]:
        """Yield the live events that follow from one event of the C chain."""
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
                yield self._settle(pinch, self._last_sample_used(e), e.known, "")
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
        yield ContactEvent(contact, is_first, pinch.epoch, self.now)

    def _last_sample_used(self, e: ChainEvent) -> int:
        """Return the number of the last sample that an estimate of the chain uses."""
        assert self.predictor is not None
        return e.sample + e.samples + self.predictor.lookahead - 1

    def _add_estimate(self, pinch: OpenClosing, e: ChainEvent) -> Estimate:
        assert self.predictor is not None
        last = self._last_sample_used(e)
        first, block, rate = pinch.contacts[0], self._block, self.layout.rate
        complete = max(last, first.decided)
        waited = (block.end - 1 - complete) / rate + self._delay
        transport = 0.0
        if self._transport is not None:
            transport = self._transport.delay(block.end - 1, self._host)
        compute = self.now - self._host
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
            host=self.now,
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
        """Return the final estimate from samples up to number ``last``.

        If there is none, return a report with the ``reason``. ``complete`` is the number of the
        last sample that was needed to decide this.
        """
        final = pinch.settle(last, self.layout.rate, real_time=self.real_time)
        if self.real_time:
            pinch.queued = processor_wait() - self._queued
            pinch.stalled = max(pinch.stalled, self.poll_gap)
        pinch.reason = reason if final is None else ""
        return final or NoEstimate(pinch.contacts[0], reason, complete, pinch.epoch)

    def _watch_strips(self, stop: int) -> None:
        """Search for contacts in the strips' samples of this closing, before number ``stop``."""
        pinch, block = self._pinch, self._block
        if pinch is None or pinch.epoch != block.epoch:
            return
        start, pinch.heard = max(pinch.heard, block.first_sample), max(pinch.heard, stop)
        if stop > start and self._strips.exist:
            data = block.data[start - block.first_sample : stop - block.first_sample]
            self._strips.watch(Block(data, start, block.epoch))

    def _ask_speed(self, sample: int, epoch: int) -> ClosingSpeed | None:
        """Return the hand's closing speed just before the contact at ``sample``; None if unknown.

        Asking the hand may take milliseconds.
        """
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
