"""Base class of sources that receive samples in a separate thread."""

from __future__ import annotations

import logging
import threading
import time
from abc import abstractmethod
from collections import deque
from dataclasses import replace
from typing import Any, NoReturn, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, DeviceError, InputError
from firstcontact.core.text import check_text, summarize_error
from firstcontact.device.clock import ClockFit, RateCheck
from firstcontact.device.descriptor import Descriptor, DevicePrediction
from firstcontact.device.source import Arrival, Health, Source
from firstcontact.recording import Marker
from firstcontact.signal import CausalResampler

_log = logging.getLogger("firstcontact.device")

#: A source without a usable sample for this time counts as disconnected, s.
SILENCE = 1.0
#: A source that never sent a usable sample is refused after this time, s.
REFUSE_AFTER = 1.8
#: Longest time between two reads that counts as silence, s. A longer time means that this process
#: was stopped.
LONGEST_PAUSE = 0.1
#: Largest usable sample, the limit of 32-bit integers. Filters and recordings can hold larger
#: values.
LARGEST_SAMPLE = 2.0**31


class QueuedSource(Source):
    """Base class of sources with a thread that puts samples into a queue for :meth:`read`."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._thread: threading.Thread | None = None
        self._closing = threading.Event()
        self._is_drained = False  # True once a reader got nothing after the end
        self._has_raised = False  # True once a reader got the error
        #: Lock of the fields below. It wakes the reader.
        self._changed = threading.Condition()
        self._finished = False
        self._error: InputError | None = None
        self._arrivals: deque[Arrival] = deque()
        self._waiting = 0  # number of samples in the queue; can be read without the lock
        self._wanted = 0  # number of samples that a reader waits for, or 0
        self._measure_rate(1.0)

    @property
    def name(self) -> str:
        return self._name

    @property
    def ended(self) -> bool:
        with self._changed:
            is_told = self._error is None or self._has_raised
            return self._finished and not self._arrivals and is_told

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        self._check_readable(timeout, is_drained=self._is_drained)
        return self._collect(timeout, least)

    def _collect(self, timeout: float, least: int) -> list[Arrival]:
        with self._changed:
            self._wanted = least
            self._changed.wait_for(self._is_enough, timeout)
            self._wanted = self._waiting = 0
            arrivals = list(self._arrivals)
            self._arrivals.clear()
            if not arrivals and self._error is not None:
                self._has_raised = True
                raise self._error
            self._is_drained = self._finished and not arrivals
            return arrivals

    def close(self) -> None:
        self._closing.set()
        if self._thread is not None:
            self._thread.join()

    @abstractmethod
    def _run(self) -> None:
        """Receive samples until ``self._closing`` is set, then call :meth:`_end`."""

    def _start(self) -> None:
        self._thread = threading.Thread(target=self._run, name=f"reader {self.name}", daemon=True)
        self._thread.start()

    def _measure_rate(self, stated: float) -> None:
        """Start to measure the sampling rate of a new epoch. ``stated`` is the stated rate, Hz."""
        self._clock, self._rate_check = ClockFit(stated), RateCheck(stated)

    def _is_enough(self) -> bool:
        return self._finished or (bool(self._arrivals) and self._waiting >= self._wanted)

    def _enqueue(self, arrival: Arrival) -> None:
        self._arrivals.append(arrival)
        self._waiting += len(arrival.block.data)

    def _wake(self) -> None:
        if self._is_enough():
            self._changed.notify_all()

    def _end(
        self,
        error: InputError | None,
        markers: list[Marker],
        predictions: list[DevicePrediction],
        number: int,
        epoch: int,
    ) -> None:
        """End the stream. Once all samples are read, :meth:`read` raises ``error``, if any.

        ``markers`` and ``predictions`` still wait for their samples. They are attached to the last
        samples or, without unread samples, to an empty block at sample ``number`` of ``epoch``.
        """
        if markers or predictions:
            no_samples = np.zeros((0, self.descriptor.layout.width), self.descriptor.dtype)
            empty = Arrival(Block(no_samples, number, epoch), time.monotonic())
            last = self._arrivals.pop() if self._arrivals else empty
            markers_, predictions_ = (*last.markers, *markers), (*last.predictions, *predictions)
            self._arrivals.append(replace(last, markers=markers_, predictions=predictions_))
        self._error, self._finished = error, True
        self._changed.notify_all()


class ThreadedSource(QueuedSource):
    """Base class of sources that receive vibration samples in a thread and resample them.

    A subclass implements ``_open``, ``_work`` and ``_shut``. ``_work`` calls ``_give``.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._descriptor: Descriptor | None = None
        # The fields below are protected by ``_changed``.
        self._markers: list[str] = []  # waiting for the next sample
        self._next = (0, 0)  # epoch and number of that sample
        self._health = Health()
        self._pending = 0  # samples lost since the last delivered one
        # The fields below belong to the receiving thread.
        self._input_rate = 0.0
        self._output_rate = 0.0
        self._resampler: tuple[int, CausalResampler] | None = None  # with its epoch
        self._unusable = 0
        #: True while the reader processes a backlog.
        self._behind = False
        self._last_check = 0.0
        self._silence = 0.0

    @abstractmethod
    def _open(self) -> Descriptor:
        """Open the port or stream, in the caller's thread. Return the source's descriptor."""

    @abstractmethod
    def _work(self) -> None:
        """Deliver samples by :meth:`_give` until ``self._closing`` is set."""

    @abstractmethod
    def _shut(self) -> None:
        """Release the port or stream, even if it could not be opened."""

    @property
    def descriptor(self) -> Descriptor:
        if self._descriptor is None:
            raise self._not_open()
        return self._descriptor

    @property
    def health(self) -> Health:
        with self._changed:
            return replace(
                self._health,
                host_rate=self._clock.rate,
                lost_samples=self._health.lost_samples + self._pending,
            )

    def __enter__(self) -> Self:
        self._descriptor = self._open()
        self._measure_rate(self._descriptor.layout.rate)
        self._last_check = time.monotonic()
        self._health = replace(self._health, connected=True)
        self._start()
        return self

    def mark(self, text: str) -> None:
        """Attach ``text`` to the next sample as a marker. Raise DeviceError if not connected."""
        check_text(text)
        with self._changed:
            if not self._health.connected:
                raise DeviceError(
                    f"{self.name} is not connected, so the marker was not set: open the source "
                    "and set it again"
                )
            self._markers.append(text)

    def _resample(self, input_rate: float, output_rate: float) -> float:
        """Set the rates of :meth:`_give`'s resampling, Hz. Return the delay by its filter, s."""
        self._input_rate, self._output_rate = input_rate, output_rate
        return CausalResampler(input_rate, output_rate).delay

    def _give(
        self,
        values: NDArray[np.floating],
        numbers: NDArray[np.int64],
        epoch: int,
        host: float,
        taken: float | None = None,
    ) -> None:
        """Resample samples and deliver them to the reader. Unusable samples become gaps.

        ``values`` has the shape (samples, channels), and ``numbers`` the number of each sample.
        ``host`` is the time at which the samples arrived, and ``taken`` the time at which the
        sender took the newest one, both in s of this computer's ``time.monotonic()``.
        """
        if not len(values):
            return
        if self._resampler is None or self._resampler[0] != epoch:
            self._resampler = epoch, CausalResampler(self._input_rate, self._output_rate)
        good = (np.abs(values) <= LARGEST_SAMPLE).all(axis=1)
        edges = np.flatnonzero((np.diff(numbers) > 1) | (good[1:] != good[:-1])) + 1
        for run in np.split(np.arange(len(values)), edges):
            if good[run[0]]:
                resampled, first = self._resampler[1].update(values[run], int(numbers[run[0]]))
                self._put(resampled.astype(np.float32), first, epoch, host, taken)
        if not good.all():
            self._unusable += int((~good).sum())
            share = self._output_rate / self._input_rate
            self._note(unusable_samples=round(self._unusable * share))
            self._drop(int(numbers[~good][-1]) + 1, epoch)

    def _drop(self, end: int, epoch: int) -> None:
        """Count all samples after the last delivered one as lost, up to ``end`` (exclusive).

        ``end`` is a number before resampling. Raises DeviceError if no usable sample has arrived
        for ``REFUSE_AFTER`` s since the source was opened.
        """
        until = -int(-end * self._output_rate // self._input_rate)
        with self._changed:
            self._begin_epoch(epoch, 0)
            self._pending = max(until - self._next[1], 0)
        self._wait()
        if not self._health.samples and self._silence >= REFUSE_AFTER:
            raise DeviceError(
                f"{self.name} sends no usable sample (all {end} are NaN, infinite, damaged, "
                f"beyond {LARGEST_SAMPLE:.3g}, or without a valid time stamp): check the sensor "
                "and the program that sends"
            )

    def _wait(self) -> bool:
        """Add up the time without a usable sample. Return True if it has reached ``SILENCE`` s.

        The source then counts as disconnected.
        """
        now = time.monotonic()
        self._silence += min(now - self._last_check, LONGEST_PAUSE)
        self._last_check = now
        if self._silence >= SILENCE and self._health.connected:
            self._note(connected=False)
        return self._silence >= SILENCE

    def _put(
        self, data: NDArray[Any], first: int, epoch: int, host: float, taken: float | None = None
    ) -> None:
        if not len(data):
            return
        self._silence, self._last_check = 0.0, time.monotonic()
        with self._changed:
            self._begin_epoch(epoch, first)
            health, self._pending = self._health, 0
            lost = health.lost_samples + first - self._next[1]
            samples = health.samples + len(data)
            self._health = replace(health, connected=True, samples=samples, lost_samples=lost)
            markers = tuple(Marker(first, text, epoch) for text in self._markers)
            self._markers.clear()
            block = Block(data, first, epoch)
            self._enqueue(Arrival(block, host, markers))
            self._next = (epoch, block.end)
            self._clock.add(block.end, host if taken is None else taken)
            self._wake()
        if self._rate_check.add(block.end, host, behind=self._behind):
            self._refuse_rate(self._rate_check.rate / self.descriptor.layout.rate, "this machine's")

    def _begin_epoch(self, epoch: int, first: int) -> None:
        if epoch == self._next[0]:
            return
        self._measure_rate(self.descriptor.layout.rate)
        health, lost = self._health, self._health.lost_samples + self._pending
        self._health = replace(
            health, epoch=epoch, reconnects=health.reconnects + 1, lost_samples=lost
        )
        self._next, self._pending = (epoch, first), 0

    def _refuse_rate(self, share: float, clock: str) -> NoReturn:
        """Raise DeviceError, because the measured rate is ``share`` times the stated rate.

        ``clock`` names the clock that measured it: "its own" or "this machine's".
        """
        stated = self._input_rate or self.descriptor.layout.rate
        raise DeviceError(
            f"{self.name} sends {share * stated:.0f} samples a second by {clock} clock, but "
            f"states {stated:.0f}: correct the stated rate, or find the cause of lost samples"
        )

    def _note(self, **counts: Any) -> None:
        with self._changed:
            self._health = replace(self._health, **counts)

    def _run(self) -> None:
        error: InputError | None = None
        try:
            self._work()
        except InputError as input_error:
            error = input_error
        except BaseException as unexpected:
            # The reader must not wait for a thread that has ended.
            _log.exception("%s: reading failed", self.name)
            reason = summarize_error(unexpected)
            error = DeviceError(f"{self.name}: reading failed ({reason}): open it again")
        try:
            self._shut()
        except BaseException:
            _log.exception("%s: closing failed", self.name)
        with self._changed:
            epoch, number = self._next
            self._end(error, [Marker(number, t, epoch) for t in self._markers], [], number, epoch)
            self._markers.clear()
            self._health = replace(self._health, connected=False)
        _log.info("%s: closed; %s", self.name, self._health)
