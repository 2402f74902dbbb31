"""Live session: a source, the pipeline, a recorder, and outputs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Protocol

from firstcontact.core import Block, Calibration, InputError, merge_blocks
from firstcontact.device import Arrival, Recorder, RecorderStatus, Source, drain
from firstcontact.models import in_words, parse_radius
from firstcontact.recording import Header, PinchMark
from firstcontact.streaming._events import Event, PinchDone
from firstcontact.streaming._fanout import Fanout
from firstcontact.streaming._hand_predictions import HandPredictions
from firstcontact.streaming._hand_requests import Ask, HandRequests
from firstcontact.streaming._objects import ObjectCombiner
from firstcontact.streaming._pipeline import Pipeline
from firstcontact.streaming._readiness import Readiness
from firstcontact.streaming._sink import Sink, Update

#: Longest wait for samples, s. It limits the time until a stop is noticed.
WAIT = 0.05
#: Longest stretch of samples that the recorder gets at once, s. Events are passed on immediately.
TOGETHER = 0.1
#: Longest time for which estimates hold back the recorder and the sinks, s.
HOLD = 0.05
#: Time after the newest samples until which the session polls for the next ones, s. A thread that
#: sleeps wakes up late, on an idle core.
POLL = 0.003
#: Time before the next samples are due at which it begins to poll, s.
EARLY = 0.0004


class Actor(Protocol):
    """Event handler in the thread of a live session. It must be fast."""

    def on_samples(self, block: Block, host: float) -> None:
        """Process new samples that arrived at ``host``, s, before :meth:`on_event` gets events."""

    def on_event(self, event: Event) -> None:
        """Process an event."""

    def after_block(self, block: Block) -> Sequence[Event]:
        """Process new samples, after :meth:`on_event` got their events. Return more events."""

    def ended(self) -> None:
        """Handle the end of the session, before anything else is closed."""


class LiveSession:
    """Live session: runs a pipeline on a source, under the control of viewers.

    Parameters
    ----------
    source
        Open source.
    pipeline
        Pipeline for the source's layout.
    actors
        Event handlers that get each event before any output does.
    recordings
        Folder for recordings that a viewer starts.
    calibration
        Calibration that is stored in the headers of the viewers' recordings.
    hand
        Requests of viewers to the hand; None without a hand.
    shape
        Shape of all objects, "flat" or a radius in mm, until a viewer sets another shape.

    Raises
    ------
    InputError
        The shape is not valid, or the model does not use it.
    """

    def __init__(
        self,
        source: Source,
        pipeline: Pipeline,
        actors: Sequence[Actor] = (),
        recordings: Path = Path(),
        calibration: Calibration | None = None,
        hand: HandRequests | None = None,
        shape: str = "",
    ) -> None:
        self._shape = shape
        self.source = source
        self._hand = hand
        self.pipeline = pipeline
        self.pinches = 0
        self.fanout: Fanout | None = None
        self._actors = actors
        self._folder = recordings
        self._calibration = calibration
        self._recorder = Recorder()
        self._noted: Path | None = None  # recording to which the next two fields belong
        self._number = 0
        self._start: tuple[int, int] | None = None
        self._arrivals: list[Arrival] = []
        self._was_connected: bool | None = None  # at the time the source was closed
        self._events: list[Event] = []
        self._given = 0  # number of the events in _events that the caller has got
        self._is_prompt = False  # True if a program waits for the events
        self._hurries: Callable[[], bool] = lambda: True  # False to wait for the recorder
        self._can_poll = source.can_poll
        self._objects = ObjectCombiner()
        device = source.descriptor.predictor
        self._hand_predictions = (
            None
            if device is None
            else HandPredictions(
                device.model, pipeline.layout.rate, checked=pipeline.predictor is not None
            )
        )
        self._figures: Mapping[str, float] = {}
        if shape:
            self.set_shape(shape)

    def run(
        self,
        sinks: Sequence[Sink] = (),
        seconds: float | None = None,
        pinches: int | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patient: bool = False,
    ) -> None:
        """Run until the source ends, all outputs have failed, or a limit is reached.

        At the end the source is closed before the recording. So the recorder and the sinks get all
        samples that the source has received.

        Parameters
        ----------
        sinks
            Outputs.
        seconds
            Longest duration, s.
        pinches
            Largest number of pinches.
        stopped
            Function that returns True to end the session; called several times a second.
        patient
            True to wait for slow sinks, until ``stopped`` or ``seconds`` have passed. Use it only
            with a source that can wait.

        Raises
        ------
        InputError
            The source failed.
        """
        for _ in self.events(sinks, seconds, pinches, stopped, patient):
            pass

    def events(
        self,
        sinks: Sequence[Sink] = (),
        seconds: float | None = None,
        pinches: int | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patient: bool = False,
    ) -> Iterator[Event]:
        """Run like :meth:`run`, and yield each event after the actors have processed it.

        Leaving the iteration ends the session.
        """
        until = math.inf if seconds is None else time.monotonic() + seconds

        def ended() -> bool:
            return stopped() or time.monotonic() >= until

        self.fanout = Fanout(sinks, self.source.descriptor, patient, ended)
        self._hurries = ended if patient else lambda: True
        together = min((sink.every for sink in sinks), default=TOGETHER)
        self._is_prompt = any(getattr(sink, "is_prompt", False) for sink in sinks)
        self._given = 0
        try:
            with Readiness(real_time=self.pipeline.real_time) as readiness:
                yield from self._follow(readiness, together, until, pinches, stopped)
            self._act(self.pipeline.finish())
            if self._hand_predictions is not None:
                self._events += self._hand_predictions.ended()
            yield from self._events[self._given :]
        finally:
            with ExitStack() as ends:  # from the last to the first, all of them even if one raises
                ends.callback(self.fanout.close)
                ends.callback(self._recorder.close)
                ends.callback(self._update)  # samples from before a fault belong in the recording
                ends.callback(self._close_source)
                for actor in self._actors:
                    ends.callback(actor.ended)

    def _follow(
        self,
        readiness: Readiness,
        together: float,
        until: float,
        pinches: int | None,
        stopped: Callable[[], bool],
    ) -> Iterator[Event]:
        """Yield the events of new samples until the source ends or a limit is reached."""
        updated = last_arrival = time.monotonic()
        is_urgent = False
        while not stopped() and time.monotonic() < until:
            new = self._read(readiness, last_arrival)
            if not new and self.source.ended:
                return
            for arrival in new:
                is_urgent |= self._take(arrival)
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

    def _read(self, readiness: Readiness, last_arrival: float) -> list[Arrival]:
        """Return the next samples. Poll for them while estimates are due."""
        is_predicting = self.pipeline.is_predicting
        readiness.hurry(is_urgent=self.pipeline.is_urgent)
        if is_predicting and self._can_poll:
            until = last_arrival + POLL
            due = last_arrival + self._least / self.pipeline.layout.rate - EARLY
            time.sleep(max(due - time.monotonic(), 0.0))
            while time.monotonic() < until:
                if new := self.source.read(0.0, self._least):
                    return new
        return self.source.read(WAIT, self._least)

    def start_recording(self) -> Path:
        """Begin a recording in the session's folder, under a free name, and return its path.

        Raises
        ------
        InputError
            A recording is running, the session has ended, or the file cannot be created.
        """
        now = datetime.now().astimezone()
        descriptor = self.source.descriptor
        header = Header(
            layout=descriptor.layout,
            source=descriptor.source,
            dtype=descriptor.dtype,
            sensor=descriptor.sensor,
            hand=descriptor.hand,
            firmware=descriptor.firmware,
            created=now.isoformat(timespec="seconds"),
            calibration=self._calibration,
        )
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self._folder} cannot be created ({error.strerror}): choose another --recordings"
            ) from error
        name = stem = f"live-{now:%Y%m%d-%H%M%S}"
        number = 1
        while True:
            path = self._folder / f"{name}.mcap"
            try:
                self._recorder.start(path, replace(header, session=name))
            except InputError as error:
                if not isinstance(error.__cause__, FileExistsError):
                    raise
                number += 1
                name = f"{stem}-{number}"
            else:
                return path

    def stop_recording(self) -> None:
        """Close the recording, if one is running."""
        self._recorder.stop()

    def mark(self, text: str) -> None:
        """Attach a marker to the next sample."""
        self.source.mark(text)

    def new_object(self) -> None:
        """Begin another object.

        Its pinches are pooled, without those of the previous object.
        """
        self._objects.new_object()
        self.pipeline.radius = parse_radius(self._shape)

    @property
    def uses_shape(self) -> bool:
        """True if the model uses the shape of the object."""
        return self.pipeline.predictor is not None and self.pipeline.predictor.uses_shape

    def set_shape(self, text: str) -> str:
        """Set the shape of the object from the next contact on.

        Returns
        -------
        str
            The shape in words; "" for an unknown shape.

        Raises
        ------
        InputError
            The shape is not valid, or the model does not use it.
        """
        if not self.uses_shape:
            raise InputError("only the network uses the shape of objects: leave the shape out")
        self.pipeline.radius = parse_radius(text)
        return in_words(self.pipeline.radius)

    def hand_asks(self) -> tuple[Ask, ...]:
        """Return the possible requests to the hand; empty without a hand."""
        return () if self._hand is None else self._hand.allowed

    def ask_hand(self, ask: Ask, by: str) -> None:
        """Send a request to the hand.

        Raises
        ------
        InputError
            There is no hand, or the hand cannot carry out the request now or ever.
        """
        if self._hand is None:
            raise InputError("This session drives no hand: start the command again with --hand")
        self._hand.ask(ask, by)

    def hand_gone(self, by: str) -> None:
        """Open the hand if the origin ``by``, now disconnected, had closed it."""
        if self._hand is not None:
            self._hand.gone(by)

    @property
    def recording(self) -> RecorderStatus:
        """State of the recorder."""
        return self._recorder.status

    @property
    def _is_deserted(self) -> bool:
        """True if all outputs have failed, and there is neither an actor nor a recording."""
        assert self.fanout is not None
        return self.fanout.deserted and not self._actors and self.recording.path is None

    @property
    def _least(self) -> int:
        """Return the number of samples that the next read waits for."""
        return 1 if self._actors and self.pipeline.is_closing else self.pipeline.due

    def _take(self, arrival: Arrival) -> bool:
        """Process samples. Return True if they have markers or events for the sinks."""
        self._arrivals.append(arrival)
        block, host = arrival.block, arrival.host
        self._objects.add_markers(arrival.markers)
        for actor in self._actors:
            actor.on_samples(block, host)
        event_count = len(self._events)
        self._act(self.pipeline.update(block, host))
        if self._hand_predictions is not None:
            self._events += self._hand_predictions.update(arrival.predictions, block, host)
        for actor in self._actors:
            self._events += actor.after_block(block)
        is_urgent = bool(arrival.markers) or len(self._events) > event_count
        corrected = self._objects.add_labels(arrival.pinches)
        self._events += [] if corrected is None else [corrected]
        return is_urgent

    def _act(self, events: Iterable[Event]) -> None:
        """Pass each event to the actors immediately, and keep it for the outputs."""
        for event in events:
            for actor in self._actors:
                actor.on_event(event)
            self._events.append(event)
            if isinstance(event, PinchDone):
                self.pinches += 1
                if self._hand_predictions is not None:
                    self._hand_predictions.add_pinch(event)
                combined = self._objects.add_pinch(event)
                self._events += [] if combined is None else [combined]

    def _close_source(self) -> None:
        """Close the source. Keep all samples that it received for the recorder and the sinks."""
        self._was_connected = self.source.health.connected
        self._arrivals += drain(self.source)

    def _update(self) -> None:
        """Pass samples and events to the recorder and the sinks."""
        assert self.fanout is not None
        arrivals, self._arrivals = _fewer(self._arrivals), []
        events, self._events = tuple(self._events), []
        pinches = [event for event in events if isinstance(event, PinchDone)]
        # Recordings begin and end in the threads of viewers.
        path = self.recording.path
        if path != self._noted:
            self._noted, self._number, self._start = path, 0, None
        if self._start is None and arrivals:
            self._start = (arrivals[0].block.epoch, arrivals[0].block.first_sample)
        self._recorder.put(arrivals)
        self._recorder.wait(self._hurries)
        for pinch in pinches:
            self._note(pinch)
        if pinches:
            self._figures = self.pipeline.ledger.summary()
        health = self.source.health
        if self._was_connected is not None:  # a source that the session closed did not go away
            health = replace(health, connected=self._was_connected)
        self.fanout.put(
            Update(
                arrivals,
                events,
                health,
                self.recording,
                self._figures,
                self.fanout.failed,
            )
        )

    def _note(self, pinch: PinchDone) -> None:
        """Add a pinch mark to the recording, if one is running."""
        is_whole = self._start is not None and (pinch.epoch, pinch.start) >= self._start
        if self._noted is None or self.recording.path != self._noted or not is_whole:
            return
        truth = tuple(c for c in pinch.strips if pinch.start <= c.sample < pinch.end)
        mark = PinchMark(
            self._number,
            pinch.start,
            pinch.end,
            pinch.epoch,
            truth=truth,
            closing_speed=pinch.closing_speed,
        )
        if not self.pipeline.layout.has_strip:
            # A person who confirms contacts later begins with the detected ones.
            detected = tuple(c for c in pinch.contacts if pinch.start <= c.sample < pinch.end)
            name = self.pipeline.detector if detected else ""
            mark = replace(mark, found=detected, found_by=name)
        self._recorder.mark(mark)
        self._number += 1


def _fewer(arrivals: list[Arrival]) -> tuple[Arrival, ...]:
    """Merge samples into as few arrivals as possible, each with the time of its newest samples."""
    hosts = {(a.block.epoch, a.block.end): a.host for a in arrivals}
    blocks = merge_blocks(a.block for a in arrivals)
    markers = tuple(m for a in arrivals for m in a.markers)
    pinches = tuple(p for a in arrivals for p in a.pinches)
    predictions = tuple(t for a in arrivals for t in a.predictions)
    last = len(blocks) - 1
    return tuple(
        Arrival(
            block,
            hosts[block.epoch, block.end],
            markers if i == 0 else (),
            pinches if i == last else (),
            predictions if i == last else (),
        )
        for i, block in enumerate(blocks)
    )
