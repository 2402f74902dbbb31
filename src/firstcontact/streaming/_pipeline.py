"""Live pipeline: it turns blocks of samples into contacts and estimates.

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

from firstcontact.chain import Chain, build_image
from firstcontact.chain.constants import DetectorKind
from firstcontact.chain.stream import Predict
from firstcontact.contact import Detector
from firstcontact.contact.closing_start import RecordedClosing, recorded_closings
from firstcontact.core import Block, Calibration, InputError, Layout, merge_blocks
from firstcontact.models import Hints
from firstcontact.models.anytime import Predictor
from firstcontact.recording import Recording
from firstcontact.signal import samples_in
from firstcontact.streaming.events import Event
from firstcontact.streaming.ledger import Ledger
from firstcontact.streaming.translator import Translator

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
        Noise floors of the fingers. Without them, only the first closing of each epoch (run of the
        device's sample counter) is detected.
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
        #: True if samples arrive in real time.
        self.real_time = real_time
        #: Translator of the chain's events into live events.
        self.translator = Translator(layout, predictor, delay, real_time=real_time)
        self._resettles = resettles
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
        self._idle = samples_in(IDLE[0], layout.rate)
        self._waiting: list[Block] = []
        self._waiting_samples = 0
        self._lot = self._idle  # samples that are processed together
        self._closings: tuple[RecordedClosing, ...] = ()
        self._run = 0  # number of the waiting samples' epoch, or of their recorded closing
        self._epoch_start = -1, 0  # epoch and its first sample
        self._has_warned = False  # of the length of an epoch
        self._has_warned_of_load = False
        self.calibrate(calibration)

    def calibrate(self, calibration: Calibration | None) -> None:
        """Set the noise floors of the fingers. Call this only before the first block."""
        self._chain = Chain(
            self._image,
            self.layout,
            calibration,
            detector=self._plugin,
            predict=None if self.predictor is None else _predict_function(self.predictor),
            contact=self.translator.touch,
            keeps_first_state=not self._resettles,
        )
        self._has_warned = self._chain.has_floors

    def follow(self, recording: Recording) -> None:
        """Detect closings where a replayed recording marks its pinches, as offline functions do.

        With noise floors, closings are detected by the motor's noise instead. Call this before the
        first block, and after :meth:`calibrate`.
        """
        if recording.pinches and not self._chain.has_floors:
            self._closings = recorded_closings(recording, self.layout.rate)
            self._has_warned = True

    def _parts(self, block: Block) -> Iterator[tuple[int, Block]]:
        """Yield (number of the closing, part) for each part of a block that is in a marked closing.

        If no closings are marked, yield (epoch, block): the whole block with its epoch, which is
        the run of the device's sample counter.
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
        self.translator.arrive(block, host)
        for run, part in self._parts(block):
            if self._waiting and (self._waiting[-1].end, self._run) != (part.first_sample, run):
                yield from self._work(host)
            self._run = run
            self._waiting.append(part)
            self._waiting_samples += len(part.data)
            if self._waiting_samples >= self._lot:
                yield from self._work(host)

    def set_batch(self, seconds: float) -> None:
        """Set the duration of the batches of samples that are processed together, s.

        It is clipped to the range from 0.018 to 0.036 s, and holds while no event is due.
        """
        self._idle = samples_in(min(max(seconds, IDLE[0]), IDLE[1]), self.layout.rate)

    @property
    def ledger(self) -> Ledger:
        """Statistics of the delays of estimates in this session."""
        return self.translator.ledger

    @property
    def is_closing(self) -> bool:
        """True from the start of a closing of the hand until the motor stops."""
        return self._chain.runs

    @property
    def is_predicting(self) -> bool:
        """True from the first contact of a closing until the last estimate for it."""
        return self.translator.is_predicting

    @property
    def is_urgent(self) -> bool:
        """True while contacts or estimates of a closing may come soon.

        Without noise floors, a closing may last as long as the stream, so only estimates count.
        """
        return self.is_predicting or (self._chain.has_floors and self._chain.is_open)

    @property
    def due(self) -> int:
        """Number of samples that are needed before the next event is possible, at least 1."""
        return max(1, self._lot - self._waiting_samples)

    def finish(self) -> list[Event]:
        """Return the remaining events of the last pinch. Call this after the last block."""
        events = list(self._work(self._clock())) if self._waiting else []
        for event in self._chain.finish():
            events += self.translator.translate(event)
        return events

    def _work(self, host: float) -> Iterator[Event]:
        start = self._clock()
        (block,) = merge_blocks(self._waiting)
        self._warn_of_long_epoch(block)
        self._waiting = []
        self._waiting_samples = 0
        self.translator.begin(block, host)
        events = self._chain.take(Block(block.data, block.first_sample, self._run))
        self.translator.now = self._clock()
        for event in events:
            yield from self.translator.translate(event)
        self.translator.end()
        if not self.translator.is_closing:
            self._warn_of_load()
        self._lot = self._chain.due(self._idle)
        self.ledger.worked(self._clock() - start, len(block.data))

    def _warn_of_long_epoch(self, block: Block) -> None:
        """Warn once that without noise floors, only one closing per epoch is detected.

        An epoch is a run of the device's sample counter. The warning comes after
        :data:`LONGEST_EPOCH` s.
        """
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
        """Warn once if motor starts do not count as closings, because a force sensor stays high."""
        if self._has_warned_of_load or self._chain.refused < REFUSED:
            return
        self._has_warned_of_load = True
        _log.warning(
            "the motor has started %d times in a row while a force was high, as if the hand held "
            "an object, so no closing was detected: if it holds none, start the session again",
            REFUSED,
        )


def _predict_function(predictor: Predictor) -> Predict:
    """Return a function with which the C chain calls a predictor's method ``predict``."""

    def predict(
        signal: bytes, lead: int, samples: int, finger: int, *hints: float
    ) -> tuple[float, float, float, float, float, bool] | None:
        try:
            return predictor.predict(np.frombuffer(signal), samples, finger, Hints(*hints))
        except InputError as error:
            _log.info("no prediction: %s", error)
            return math.nan, math.nan, math.nan, math.nan, math.nan, False

    return predict
