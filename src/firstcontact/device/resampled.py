"""Source that resamples another source to the sampling rate of a model."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import replace
from typing import Self

import numpy as np

from firstcontact.core import Block, ChannelKind, ClosingSpeed, Contact
from firstcontact.device.descriptor import Descriptor, DeviceContact, DevicePrediction
from firstcontact.device.source import Arrival, Health, Source
from firstcontact.recording import Marker, PinchMark
from firstcontact.signal import CausalResampler
from firstcontact.signal.resampling import check_rates


class ResampledSource(Source):
    """Source that resamples another open source to the sampling rate ``rate``, Hz.

    Contact strips take the value of the nearest sample. Up to 0.5 ms of signal before each gap are
    lost, because the filter cannot look ahead there.
    """

    def __init__(self, source: Source, rate: float) -> None:
        self._source, self._rate = source, rate
        self.speed, self.is_replay = source.speed, source.is_replay
        self.calibration, self.twin_hand = source.calibration, source.twin_hand
        layout = source.descriptor.layout
        check_rates(layout.rate, rate)
        self._old = layout.rate
        self._share = rate / layout.rate
        self._strips = layout.columns(ChannelKind.STRIP)
        self._resampler = self._new_resampler()
        self._epoch: int | None = None
        self._end = 0  # number of the source's next sample
        self._next = 0  # number of the next output sample
        self._given = 0
        self._cut = 0.0  # samples by which gaps are longer than in the source
        self._host = 0.0
        # Markers and marks that wait for their sample.
        self._markers: list[Marker] = []
        self._pinches: list[PinchMark] = []

    @property
    def name(self) -> str:
        return self._source.name

    @property
    def descriptor(self) -> Descriptor:
        descriptor = self._source.descriptor
        layout = replace(descriptor.layout, rate=self._rate, groups=())
        delay = descriptor.delay + self._resampler.delay
        return replace(descriptor, layout=layout, dtype="float32", delay=delay)

    @property
    def health(self) -> Health:
        health = self._source.health
        return replace(
            health,
            samples=self._given,
            lost_samples=round(health.lost_samples * self._share + self._cut),
            overflow_samples=round(health.overflow_samples * self._share),
            unusable_samples=round(health.unusable_samples * self._share),
            unheard_samples=round(health.unheard_samples * self._share),
            host_rate=health.host_rate * self._share,
            ended=health.ended and not self._waiting,
        )

    @property
    def ended(self) -> bool:
        return self._source.ended and not self._waiting

    @property
    def _waiting(self) -> bool:
        return bool(self._markers or self._pinches)

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        until = time.monotonic() + timeout
        while not self._source.ended:
            patience = max(until - time.monotonic(), 0.0)
            arrivals = self._source.read(patience, math.ceil(least / self._share))
            pieces = [piece for arrival in arrivals for piece in self._resample_arrival(arrival)]
            if pieces or not arrivals:
                return pieces
        return self._leftovers() or self._source.read(timeout)  # refuses if it was closed

    def closing_speed(self, sample: int, epoch: int) -> ClosingSpeed | None:
        return self._source.closing_speed(round(sample / self._share), epoch)

    def positions_since(self, since: float) -> list[tuple[float, float]]:
        return self._source.positions_since(since)

    def mark(self, text: str) -> None:
        self._source.mark(text)

    def order(self, text: str) -> None:
        self._source.order(text)

    def close(self) -> None:
        self._source.close()

    def __enter__(self) -> Self:
        return self

    def _new_resampler(self, origin: int = 0) -> CausalResampler:
        return CausalResampler(self._old, self._rate, self._strips, origin)

    def _resample_arrival(self, arrival: Arrival) -> list[Arrival]:
        """Resample samples that have arrived. Return what the reader can get now.

        If a new epoch begins, the markers that remain from the old epoch come first.
        """
        block, leftovers = arrival.block, []
        is_new_epoch = block.epoch != self._epoch
        if is_new_epoch:
            leftovers = self._leftovers()
            self._resampler = self._new_resampler(block.first_sample)
            self._next = self._resampler.number(block.first_sample)
        data, first = self._resampler.update(block.data, block.first_sample)
        if len(block.data):
            if not is_new_epoch:
                gap = block.first_sample - self._end
                self._cut += first - self._next - gap * self._share
            self._next, self._end = first + len(data), block.end
        self._epoch, self._host = block.epoch, arrival.host
        self._given += len(data)
        number = self._resampler.number
        self._markers += [replace(m, sample=number(m.sample)) for m in arrival.markers]
        self._pinches += [self._moved(pinch) for pinch in arrival.pinches]
        predictions = tuple(self._moved_prediction(t) for t in arrival.predictions)
        begin = self._next - len(data)
        return leftovers + self._ready_arrivals(
            Block(data.astype(np.float32), begin, block.epoch), predictions
        )

    def _ready_arrivals(
        self, block: Block, predictions: tuple[DevicePrediction, ...]
    ) -> list[Arrival]:
        """Return one arrival: the block, the predictions, and all marks before the block's end.

        These are markers and marks of pinches. Return [] if there is nothing to deliver.
        """
        end = block.epoch, block.end
        markers = tuple(m for m in self._markers if (m.epoch, m.sample) < end)
        pinches = tuple(p for p in self._pinches if (p.epoch, p.first_sample) < end)
        if not (len(block.data) or markers or pinches or predictions):
            return []
        self._markers = [m for m in self._markers if m not in markers]
        self._pinches = [p for p in self._pinches if p not in pinches]
        return [Arrival(block, self._host, markers, pinches, predictions)]

    def _leftovers(self) -> list[Arrival]:
        """Return the marks whose samples cannot come any more, because their epoch has ended."""
        if not self._waiting:
            return []
        no_samples = np.zeros((0, self.descriptor.layout.width), np.float32)
        block = Block(no_samples, self._next, self._epoch or 0)
        arrival = Arrival(block, self._host, tuple(self._markers), tuple(self._pinches))
        self._markers, self._pinches = [], []
        return [arrival]

    def _moved(self, pinch: PinchMark) -> PinchMark:
        number = self._resampler.number

        def contacts(contacts_: Iterable[Contact]) -> tuple[Contact, ...]:
            return tuple(Contact(c.finger, number(c.sample), number(c.decided)) for c in contacts_)

        return replace(
            pinch,
            first_sample=number(pinch.first_sample),
            end=number(pinch.end),
            truth=contacts(pinch.truth),
            found=contacts(pinch.found),
            motor_start=None if pinch.motor_start is None else number(pinch.motor_start),
        )

    def _moved_prediction(self, moved: DevicePrediction) -> DevicePrediction:
        number = self._resampler.number
        decided = number(moved.decided)
        if isinstance(moved, DeviceContact):
            return replace(moved, sample=number(moved.sample), decided=decided)
        samples = round(moved.samples * self._share)
        return replace(moved, contact=number(moved.contact), decided=decided, samples=samples)
