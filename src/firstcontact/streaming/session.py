"""Live session, which passes samples from a source to the pipeline, the recorder and outputs."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from firstcontact.core import ArgumentError, Calibration, ModelError, merge_blocks
from firstcontact.core.physics import parse_radius, radius_text
from firstcontact.core.quantity import SHORE_A, Quantity
from firstcontact.device import Arrival, Source
from firstcontact.device.recorder import RecorderStatus
from firstcontact.device.source import drain
from firstcontact.models import Model
from firstcontact.streaming._hand_predictions import HandPredictions
from firstcontact.streaming._objects import ObjectCombiner
from firstcontact.streaming._pipeline import Pipeline
from firstcontact.streaming._sinks import Fanout, Sink, Update
from firstcontact.streaming.events import Ask, Event, PinchDone
from firstcontact.streaming.grasping import Grasping, HandRequests
from firstcontact.streaming.real_time import real_time_process
from firstcontact.streaming.session_recording import SessionRecording

#: Longest wait for samples, s. It limits the time until a stop is noticed.
WAIT = 0.05
#: Longest stretch of samples that the recorder gets at once, s. Events are passed on immediately.
TOGETHER = 0.1
#: Longest time for which estimates hold back the recorder and the sinks, s.
HOLD = 0.05
#: Time after the newest samples until which the session polls for the next ones, s. A thread that
#: sleeps wakes up late, on an idle core.
POLL = 0.002
#: Time before the next samples are due at which it begins to poll, s.
EARLY = 0.0004

_log = logging.getLogger("firstcontact.streaming")


class LiveSession:
    """Running live session: a pipeline on an open source, with recordings, outputs and a hand.

    ``grasping`` drives the hand, and gets each event before the outputs do. ``notify`` gets a line
    on the permissions that the system granted to a session in real time.
    """

    def __init__(
        self,
        source: Source,
        pipeline: Pipeline,
        grasping: Grasping | None = None,
        *,
        recordings: Path = Path(),
        calibration: Calibration | None = None,
        shape: str = "",
        model: Model | None = None,
        notify: Callable[[str], None] = _log.info,
    ) -> None:
        self.source = source
        self.pipeline = pipeline
        self.model = model
        self.grasping = grasping
        self.fanout = Fanout((), source.descriptor)
        self.pinches = 0
        self.notify = notify
        self._shape = shape
        self._recording = SessionRecording(
            source, recordings, calibration, grasping, pipeline.detector
        )
        #: Begin a recording in the session's folder under an unused name. Return its path.
        self.start_recording = self._recording.start
        #: End the recording and return its path; None if none was running.
        self.stop_recording = self._recording.stop
        self._arrivals: list[Arrival] = []
        self._was_connected: bool | None = None  # at the time the source was closed
        self._events: list[Event] = []
        self._given = 0  # number of the events in _events that the caller has got
        self._is_prompt = False  # True if a program waits for the events
        self._hurries: Callable[[], bool] = lambda: True  # False to wait for the recorder
        self._can_poll = source.can_poll
        self._objects = ObjectCombiner()
        self._names: dict[int, str] = {}  # objects of the pinches that are not recorded yet
        device, is_checked = source.descriptor.predictor, pipeline.predictor is not None
        self._hand_predictions = (
            None
            if device is None
            else HandPredictions(device.model, pipeline.layout.rate, checked=is_checked)
        )
        self._figures: Mapping[str, float] = {}
        self._reported: set[str] = set()  # failed outputs that the others know of
        if shape:
            self.set_shape(shape)

    def run(self, sinks: Sequence[Sink] = (), **limits: Any) -> None:
        """Run the session without returning events; parameters as in :meth:`events`."""
        for _ in self.events(sinks, **limits):
            pass

    def events(
        self,
        sinks: Sequence[Sink] = (),
        seconds: float | None = None,
        pinches: int | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patient: bool = False,
    ) -> Iterator[Event]:
        """Run the session and yield its events, until the source ends or a limit is reached.

        The session also ends if all outputs have failed. ``sinks`` are the outputs, and ``seconds``
        and ``pinches`` the limits. ``stopped`` returns True to stop. ``patient`` waits for slow
        outputs instead of dropping updates.
        """
        until = math.inf if seconds is None else time.monotonic() + seconds

        def ended() -> bool:
            return stopped() or time.monotonic() >= until

        self.fanout = Fanout(sinks, self.source.descriptor, patient, ended)
        self._hurries = ended if patient else lambda: True
        together = min((sink.every for sink in sinks), default=TOGETHER)
        self.pipeline.set_batch(together if self.grasping is None else 0.0)
        self._is_prompt = any(getattr(sink, "is_prompt", False) for sink in sinks)
        self._given, self._reported = 0, set()
        try:
            real_time = self.pipeline.real_time
            with real_time_process(real_time=real_time, notify=self.notify) as hurry:
                yield from self._follow(hurry, together, until, pinches, stopped)
            self._dispatch_events(self.pipeline.finish())
            if self._hand_predictions is not None:
                self._events += self._hand_predictions.ended()
            yield from self._events[self._given :]
        finally:
            with ExitStack() as ends:  # from the last to the first, all of them even if one raises
                ends.callback(self.fanout.close)
                ends.callback(self._recording.close)
                ends.callback(self._update)  # samples from before a fault belong in the recording
                ends.callback(self._close_source)
                if self.grasping is not None:
                    ends.callback(self.grasping.ended)

    def _follow(
        self,
        hurry: Callable[[bool], None],
        together: float,
        until: float,
        pinches: int | None,
        stopped: Callable[[], bool],
    ) -> Iterator[Event]:
        """Yield events until the source ends or a limit is reached.

        ``hurry(True)`` pauses the garbage collector. ``together`` is the longest time between
        updates of the outputs, s, ``until`` the end by ``time.monotonic()``, s. ``pinches`` is the
        number of pinches after which the session ends, None for any number. ``stopped`` returns
        True to end it now.
        """
        updated = last_arrival = time.monotonic()
        is_urgent = False
        while not stopped() and time.monotonic() < until:
            hurry(self.pipeline.is_urgent)
            new = self._read(last_arrival)
            if not new and self.source.ended:
                return
            for arrival in new:
                is_urgent |= self._process_arrival(arrival)
            now = time.monotonic()
            if new:
                last_arrival = now
            fresh, self._given = self._events[self._given :], len(self._events)
            # Other threads get nothing to do while estimates are due, unless a program waits.
            if is_urgent and (self._is_prompt or not self.pipeline.is_predicting):
                wait = 0.0
            else:
                wait = HOLD if self.pipeline.is_predicting else together
            if now - updated >= wait:
                # Update before the caller gets the events: it may take long, or never come back.
                self._update()
                updated, is_urgent, self._given = now, False, 0
            yield from fresh
            if (pinches is not None and self.pinches >= pinches) or self._is_deserted:
                return

    def _read(self, last_arrival: float) -> list[Arrival]:
        """Wait for new samples, and return them. While an estimate is due, poll without sleeping.

        ``last_arrival`` is the time at which the last samples arrived, by ``time.monotonic()``, s.
        """
        if self.pipeline.is_predicting and self._can_poll:
            until = last_arrival + POLL
            due = last_arrival + self._least / self.pipeline.layout.rate - EARLY
            now = max(due, time.monotonic())
            time.sleep(max(due - time.monotonic(), 0.0))
            new: list[Arrival] = []
            while not new and now < until:
                new = self.source.read(0.0, self._least)
                polled, now = now, time.monotonic()
                translator = self.pipeline.translator
                translator.poll_gap = max(translator.poll_gap, now - polled)
            if new:
                return new
        return self.source.read(WAIT, self._least)

    def mark(self, text: str) -> None:
        self.source.mark(text)

    def new_object(self) -> None:
        """Count the next pinch as one of a new object, for the average over pinches."""
        self._objects.new_object()
        self.pipeline.translator.radius = parse_radius(self._shape)

    @property
    def quantity(self) -> Quantity:
        """Quantity that the session estimates, such as Shore A."""
        predictor = self.pipeline.predictor
        return SHORE_A if predictor is None else predictor.quantity

    @property
    def uses_shape(self) -> bool:
        """True if the session's predictor uses the shape of the object."""
        return self.pipeline.predictor is not None and self.pipeline.predictor.uses_shape

    def set_shape(self, text: str) -> str:
        """Set the shape of the touched objects, from the next contact on. Return it in words.

        ``text`` is "flat", a radius in mm, or "" if unknown. Raise InputError if no shape can be
        used.
        """
        if not self.uses_shape:
            raise ModelError(
                "this model cannot use an object's shape: leave the shape out, or use a model with "
                "the neural network"
            )
        self.pipeline.translator.radius = parse_radius(text)
        return radius_text(self.pipeline.translator.radius)

    def hand_asks(self) -> tuple[Ask, ...]:
        return () if self._requests is None else self._requests.allowed

    def ask_hand(self, ask: Ask, by: str) -> None:
        """Send the request of ``by``, such as a viewer, to the hand.

        Raise InputError if there is no hand, or it cannot do that.
        """
        if self._requests is None:
            raise ArgumentError("This session drives no hand: start the command again with --hand")
        self._requests.ask(ask, by)

    def hand_gone(self, by: str) -> None:
        """Open the hand if the viewer ``by``, who has disconnected, had closed it."""
        if self._requests is not None:
            self._requests.gone(by)

    @property
    def recording(self) -> RecorderStatus:
        return self._recording.status

    @property
    def _requests(self) -> HandRequests | None:
        return None if self.grasping is None else self.grasping.requests

    @property
    def _is_deserted(self) -> bool:
        """True if all outputs have failed, and there is neither a hand nor a recording."""
        return self.fanout.deserted and self.grasping is None and self.recording.path is None

    @property
    def _least(self) -> int:
        return 1 if self.grasping is not None and self.pipeline.is_closing else self.pipeline.due

    def _process_arrival(self, arrival: Arrival) -> bool:
        """Process samples that have arrived. Return True if outputs should get them immediately."""
        self._arrivals.append(arrival)
        block, host = arrival.block, arrival.host
        if arrival.markers or arrival.pinches:
            self._objects.add_markers(arrival.markers)
            self._objects.add_labels(arrival.pinches)
        if self.grasping is not None:
            self.grasping.on_samples(block, host)
        event_count = len(self._events)
        self._dispatch_events(self.pipeline.update(block, host))
        if self._hand_predictions is not None:
            self._events += self._hand_predictions.update(arrival.predictions, block, host)
        if self.grasping is not None:
            self._events += self.grasping.after_block(block)
        return bool(arrival.markers) or len(self._events) > event_count

    def _dispatch_events(self, events: Iterable[Event]) -> None:
        """Pass each event to the grasp policy, and store it for the outputs."""
        for event in events:
            if self.grasping is not None:
                self.grasping.on_event(event)
                is_used = self.grasping.is_used
                if isinstance(event, PinchDone) and is_used is not None:
                    event = msgspec.structs.replace(event, hand_used=is_used)
                    self.pipeline.ledger.count_use(is_used=is_used)
            self._events.append(event)
            if self.grasping is not None:
                self._events += self.grasping.take_commands()
            if isinstance(event, PinchDone):
                self.pinches += 1
                if self._hand_predictions is not None:
                    self._hand_predictions.add_pinch(event)
                combined = self._objects.pool(event)
                self._events += [] if combined is None else [combined]
                self._names[event.number] = self._objects.name

    def _close_source(self) -> None:
        """Store the samples that the source has received, and close it."""
        self._was_connected = self.source.health.connected
        self._arrivals += drain(self.source)

    def _update(self) -> None:
        """Pass the stored samples and events to the recorder and the outputs."""
        arrivals, self._arrivals = _merge_arrivals(self._arrivals), []
        events, self._events = tuple(self._events), []
        pinches = [event for event in events if isinstance(event, PinchDone)]
        self._recording.add(
            arrivals,
            [(pinch, self._names.pop(pinch.number)) for pinch in pinches],
            is_predicting=self.pipeline.is_predicting,
            hurries=self._hurries,
        )
        if pinches:
            self._figures = self.pipeline.ledger.summary()
        health = self.source.health
        if self._was_connected is not None:  # a source that the session closed did not go away
            health = replace(health, connected=self._was_connected)
        failed = {n: why for n, why in self.fanout.failed.items() if n not in self._reported}
        self._reported |= failed.keys()
        self.fanout.put(Update(arrivals, events, health, self.recording, self._figures, failed))


def _merge_arrivals(arrivals: list[Arrival]) -> tuple[Arrival, ...]:
    """Merge arrivals whose samples follow each other without a gap.

    A merged arrival has the arrival time of its last samples.
    """
    hosts = {(a.block.epoch, a.block.end): a.host for a in arrivals}
    blocks = merge_blocks(a.block for a in arrivals)
    markers = tuple(m for a in arrivals for m in a.markers)
    pinches = tuple(p for a in arrivals for p in a.pinches)
    predictions = tuple(t for a in arrivals for t in a.predictions)
    return tuple(
        Arrival(
            block,
            hosts[block.epoch, block.end],
            *((markers, pinches, predictions) if i == 0 else ()),
        )
        for i, block in enumerate(blocks)
    )
