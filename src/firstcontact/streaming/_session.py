"""A live session: a source, the pipeline, a recorder and whoever looks on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Protocol

from firstcontact.core import Block, Calibration, Contact, InputError, merge_blocks
from firstcontact.device import Arrival, Recorder, RecorderStatus, Source, drain
from firstcontact.models import in_words, radius_of
from firstcontact.recording import Header, PinchMark
from firstcontact.streaming._events import Event, PinchDone
from firstcontact.streaming._fanout import Fanout
from firstcontact.streaming._hand_answers import HandAnswers
from firstcontact.streaming._hand_requests import Ask, HandRequests
from firstcontact.streaming._pipeline import Pipeline
from firstcontact.streaming._same_object import Pinched
from firstcontact.streaming._sink import Sink, Update

#: Longest wait for samples, s: how soon a stop is noticed.
WAIT = 0.05
#: Samples go to the recorder together for so long at most, s; what was found at once.
TOGETHER = 0.1


class Actor(Protocol):
    """Acts on what happens, in the session's own thread: must be quick."""

    def arrived(self, block: Block, host: float) -> None:
        """Samples came at a time of the host's clock, s; what is found in them is told next."""

    def happened(self, event: Event) -> None:
        """Something was found."""

    def came(self, block: Block) -> Sequence[Event]:
        """What was found in the samples that came was told: what it has to tell itself."""

    def ended(self) -> None:
        """The session ends, for whatever reason: told before anything else is closed."""


class LiveSession:
    """Runs a pipeline on a source until either ends; is what viewers control.

    Parameters
    ----------
    source
        Open.
    pipeline
        For the source's layout.
    actors
        Told of each event before anything else sees it.
    recordings
        Folder for recordings that a viewer starts.
    calibration
        Goes into their headers.
    hand
        Takes what viewers ask of the hand; None where none is driven.
    shape
        Of every object whose shape no viewer tells, as
        :func:`firstcontact.models._shape_hint.radius_of` reads it; "" tells none.

    Raises
    ------
    InputError
        A shape that cannot be told, or no model that could use it.
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
        self._noted: Path | None = None  # recording that the next two are about
        self._number = 0
        self._from: tuple[int, int] | None = None
        self._arrivals: list[Arrival] = []
        self._was_connected: bool | None = None  # when the session closed the source
        self._events: list[Event] = []
        self._pinched = Pinched()
        answers = source.descriptor.predictor
        self._hand_answers = (
            None
            if answers is None
            else HandAnswers(answers.model, pipeline.layout.rate, pipeline.answers_at_any_time)
        )
        self._figures: Mapping[str, float] = {}
        if shape:
            self.tell_shape(shape)

    def run(
        self,
        sinks: Sequence[Sink] = (),
        seconds: float | None = None,
        pinches: int | None = None,
        stopped: Callable[[], bool] = lambda: False,
        patient: bool = False,
    ) -> None:
        """Work until the source ends, nobody is left to tell, or one of these bounds.

        The source is closed at the end, before a recording: all samples that it counts as received
        are then with the recorder and the sinks.

        Parameters
        ----------
        sinks
            Viewers and other programs.
        seconds
            Longest time, s.
        pinches
            Most pinches.
        stopped
            Asked several times a second whether to end.
        patient
            Wait for slow sinks: for a source that waits, too.

        Raises
        ------
        InputError
            What the source raises.
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
        """Work as :meth:`run` does, and give each event to the caller when actors have seen it.

        Leaving the iteration ends the session.
        """
        self.fanout = Fanout(sinks, self.source.descriptor, patient)
        until = None if seconds is None else time.monotonic() + seconds
        told = time.monotonic()
        together = min((sink.every for sink in sinks), default=TOGETHER)
        given = 0  # of the events that sinks have not got yet, so many the caller has
        try:
            while not stopped() and (until is None or time.monotonic() < until):
                new = self.source.read(WAIT, self._least)
                if not new and self.source.ended:
                    break
                found = False
                for arrival in new:
                    self._arrivals.append(arrival)
                    found |= bool(arrival.markers)
                    self._pinched.words(arrival.markers)
                    for actor in self._actors:
                        actor.arrived(arrival.block, arrival.host)
                    found |= self._act(self.pipeline.update(arrival.block, arrival.host))
                    if self._hand_answers is not None:
                        came = self._hand_answers.came(
                            arrival.predictions, arrival.block, arrival.host
                        )
                        self._events += came
                        found |= bool(came)
                    corrected = self._pinched.labels(arrival.pinches)
                    self._events += [] if corrected is None else [corrected]
                    for actor in self._actors:
                        said = actor.came(arrival.block)
                        self._events += said
                        found |= bool(said)
                # Recorder and sinks first: the caller may take its time, or never come back.
                fresh, given = self._events[given:], len(self._events)
                if found or time.monotonic() - told >= together:
                    self._tell()
                    told = time.monotonic()
                    given = 0
                yield from fresh
                if (pinches is not None and self.pinches >= pinches) or self._alone:
                    break
            self._act(self.pipeline.finish())
            if self._hand_answers is not None:
                self._events += self._hand_answers.ended()
            yield from self._events[given:]
        finally:
            with ExitStack() as ends:  # the last first, and all of them whatever one of them raises
                ends.callback(self.fanout.close)
                ends.callback(self._recorder.stop)
                ends.callback(self._tell)  # samples from before a fault belong in the recording
                ends.callback(self._close_source)
                for actor in self._actors:
                    ends.callback(actor.ended)

    def start_recording(self) -> Path:
        """Begin a recording in the session's folder."""
        path = self._folder / f"live-{datetime.now():%Y%m%d-%H%M%S}.mcap"
        descriptor = self.source.descriptor
        header = Header(
            layout=descriptor.layout,
            source=descriptor.source,
            dtype=descriptor.dtype,
            sensor=descriptor.sensor,
            hand=descriptor.hand,
            firmware=descriptor.firmware,
            session=path.stem,
            created=datetime.now().astimezone().isoformat(timespec="seconds"),
            calibration=self._calibration,
        )
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self._folder} cannot be made ({error.strerror}): choose another --recordings"
            ) from error
        self._recorder.start(path, header)
        return path

    def stop_recording(self) -> None:
        """Close the recording; nothing happens when none is running."""
        self._recorder.stop()

    def mark(self, text: str) -> None:
        """Pin a word to the next sample."""
        self.source.mark(text)

    def new_object(self) -> None:
        """The next pinches are of one object, and of another than before: combine them."""
        self._pinched.anew()
        self.pipeline.radius = radius_of(self._shape)

    @property
    def combines(self) -> bool:
        """Whether there are answers that can be combined over pinches of one object."""
        return self.pipeline.answers_at_any_time

    @property
    def shapes(self) -> bool:
        """Whether it is of use to tell the shape of what is pinched."""
        return self.pipeline.answers_at_any_time

    def tell_shape(self, text: str) -> str:
        """The object that is pinched from the next closing on has this shape.

        Returns
        -------
        str
            What was understood, "" where no shape is told any more.

        Raises
        ------
        InputError
            No shape that can be told, or no model that could use it.
        """
        if not self.shapes:
            raise InputError("no any-time model answers here: leave the shape out, it is of no use")
        self.pipeline.radius = radius_of(text)
        return in_words(self.pipeline.radius)

    def hand_asks(self) -> tuple[Ask, ...]:
        """What the hand can be asked; nothing where none is driven."""
        return () if self._hand is None else self._hand.allowed

    def ask_hand(self, ask: Ask, by: str) -> None:
        """Ask the hand for something.

        Raises
        ------
        InputError
            No hand is driven, or it cannot be asked for that, or not now.
        """
        if self._hand is None:
            raise InputError("No hand is driven: start again with --hand")
        self._hand.ask(ask, by)

    def hand_gone(self, by: str) -> None:
        """Somebody can ask no more: what they had the hand close is opened."""
        if self._hand is not None:
            self._hand.gone(by)

    @property
    def recording(self) -> RecorderStatus:
        """What the recorder is doing."""
        return self._recorder.status

    @property
    def _alone(self) -> bool:
        """Whether nobody gets anything any more."""
        assert self.fanout is not None
        return self.fanout.deserted and not self._actors and self.recording.path is None

    @property
    def _least(self) -> int:
        """Samples worth waking up for; actors feel what they hold at all times."""
        return 1 if self._actors and self.pipeline.closing else self.pipeline.due

    def _act(self, events: Iterable[Event]) -> bool:
        """Let actors act on each event at once, and keep it for everybody else."""
        found = False
        for event in events:
            found = True
            for actor in self._actors:
                actor.happened(event)
            self._events.append(event)
            if isinstance(event, PinchDone):
                self.pinches += 1
                if self._hand_answers is not None:
                    self._hand_answers.done(event)
                combined = self._pinched.done(event)
                self._events += [] if combined is None else [combined]
        return found

    def _close_source(self) -> None:
        """Close the source and keep the samples that it received for the recorder and the sinks."""
        self._was_connected = self.source.health.connected
        self._arrivals += drain(self.source)

    def _tell(self) -> None:
        """Hand what has come to the recorder and the sinks."""
        assert self.fanout is not None
        arrivals, self._arrivals = _fewer(self._arrivals), []
        events, self._events = tuple(self._events), []
        done = [event for event in events if isinstance(event, PinchDone)]
        # Recordings begin and end in the threads of viewers: seen from here, in this one.
        path = self.recording.path
        if path != self._noted:
            self._noted, self._number, self._from = path, 0, None
        if self._from is None and arrivals:
            self._from = (arrivals[0].block.epoch, arrivals[0].block.first_sample)
        self._recorder.put(arrivals)
        for pinch in done:
            self._note(pinch)
        if done:
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

    def _note(self, done: PinchDone) -> None:
        """Mark the pinch in the recording, if there is one; the strips are its truth."""
        whole = self._from is not None and (done.epoch, done.armed) >= self._from
        if self._noted is None or self.recording.path != self._noted or not whole:
            return
        inside = [(f, s) for f, s in done.strips if done.armed <= s < done.end]
        truth = tuple(Contact(f, s, s) for f, s in inside)
        mark = PinchMark(self._number, done.armed, done.end, done.epoch, truth=truth)
        if not self.pipeline.layout.has_strip:
            # Who confirms contacts later begins with these, and sees that nobody has yet.
            told = tuple(c for c in done.contacts if done.armed <= c.sample < done.end)
            mark = replace(mark, found=told, found_by=self.pipeline.detector if told else "")
        self._recorder.mark(mark)
        self._number += 1


def _fewer(arrivals: list[Arrival]) -> tuple[Arrival, ...]:
    """The same samples in as few arrivals as can be, each as late as its last."""
    hosts = {(a.block.epoch, a.block.end): a.host for a in arrivals}
    blocks = merge_blocks(a.block for a in arrivals)
    markers = tuple(m for a in arrivals for m in a.markers)
    pinches = tuple(p for a in arrivals for p in a.pinches)
    told = tuple(t for a in arrivals for t in a.predictions)
    last = len(blocks) - 1
    return tuple(
        Arrival(
            block,
            hosts[block.epoch, block.end],
            markers if i == 0 else (),
            pinches if i == last else (),
            told if i == last else (),
        )
        for i, block in enumerate(blocks)
    )
