"""What sources have in common whose samples a thread of their own takes off a line."""

from __future__ import annotations

import logging
import threading
import time
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, NoReturn, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, InputError, summarize_error
from firstcontact.device._clock import ClockFit
from firstcontact.device._inbox import Inbox
from firstcontact.device._source import Arrival, Descriptor, Health
from firstcontact.device._stream_checks import LARGEST_SAMPLE, RateCheck, usable_samples
from firstcontact.recording import Marker
from firstcontact.signal import CausalResampler

_log = logging.getLogger(__name__)

#: A source without a usable sample for this long counts as not connected, s.
SILENCE = 1.0
#: A source that never sent a usable sample is refused after this long, s.
REFUSED = 1.8
#: Longest time between two looks at the line that counts as silence, s. A process that was
#: stopped for longer did not look.
LOOK = 0.1


class ThreadedSource(ABC):
    """A source that says how it is opened, read and shut; queue, counts and words are here.

    Parameters
    ----------
    name
        What a person calls it.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._thread: threading.Thread | None = None
        self._closing = threading.Event()
        self._descriptor: Descriptor | None = None
        self._inbox = Inbox()
        # What follows is changed and looked at with its lock.
        self._words: list[str] = []  # that wait for the next sample
        self._next = (0, 0)  # epoch and number of that sample
        self._health = Health()
        self._clock = ClockFit(1.0)
        self._pending = 0  # lost since the last sample that was given
        # What follows belongs to the thread that works.
        self._input_rate = 0.0
        self._output_rate = 0.0
        self._resampler: tuple[int, CausalResampler] | None = None  # with its epoch
        self._unusable = 0
        self._rate_check = RateCheck(1.0)
        self._looked = 0.0
        self._silence = 0.0

    @abstractmethod
    def _open(self) -> Descriptor:
        """Open it, in the thread of who enters it.

        Raises
        ------
        InputError
            It cannot be; what was opened is shut again.
        """

    @abstractmethod
    def _work(self) -> None:
        """Give samples until ``self._closing`` is set.

        Raises
        ------
        InputError
            It is gone for good: told to who reads, behind the last sample.
        """

    @abstractmethod
    def _shut(self) -> None:
        """Let go of it, in the thread that worked; may be called when nothing was opened."""

    @property
    def name(self) -> str:
        """What a person calls it."""
        return self._name

    @property
    def descriptor(self) -> Descriptor:
        """What it says about itself."""
        if self._descriptor is None:
            raise InputError(f"{self.name} is not open: enter the source first")
        return self._descriptor

    @property
    def health(self) -> Health:
        """Counts up to now."""
        with self._inbox.changed:
            return replace(
                self._health,
                host_rate=self._clock.rate,
                lost_samples=self._health.lost_samples + self._pending,
            )

    @property
    def ended(self) -> bool:
        """Whether nothing more will come, all was read and every error told."""
        return self._inbox.ended

    def __enter__(self) -> Self:
        self._descriptor = self._open()
        rate = self._descriptor.layout.rate
        self._clock, self._rate_check = ClockFit(rate), RateCheck(rate)
        self._looked = time.monotonic()
        self._health = replace(self._health, connected=True)
        self._thread = threading.Thread(target=self._run, name=f"reader {self.name}", daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """All that has come since the last call, waiting up to ``timeout`` s for so much.

        Raises
        ------
        InputError
            It is gone for good.
        """
        return self._inbox.read(timeout, least)

    def mark(self, text: str) -> None:
        """Have a word pinned to the next sample.

        Raises
        ------
        InputError
            It is not there.
        """
        with self._inbox.changed:
            if not self._health.connected:
                raise InputError(f"{self.name} is not there and the marker was not set: open it")
            self._words.append(text)

    def order(self, text: str) -> None:  # noqa: B027
        """Take no notice: nothing here is a simulated hand."""

    def close(self) -> None:
        """Stop it and let go of it; what came can still be read. Closing twice is fine."""
        self._closing.set()
        if self._thread is not None:
            self._thread.join()

    def _resample(self, input_rate: float, output_rate: float) -> float:
        """Set both rates of :meth:`_give`, Hz. Return the delay of its filter, s."""
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
        """Give samples at the output rate; unusable ones become gaps.

        Parameters
        ----------
        values
            Samples at the input rate, shape (samples, channels).
        numbers
            Their numbers, rising, shape (samples,).
        epoch, host, taken
            As of :meth:`_put`.

        Raises
        ------
        InputError
            The source has never sent a usable sample, or has another rate than it states.
        """
        if not len(values):
            return
        if self._resampler is None or self._resampler[0] != epoch:
            self._resampler = epoch, CausalResampler(self._input_rate, self._output_rate)
        good = usable_samples(values)
        edges = np.flatnonzero((np.diff(numbers) > 1) | (good[1:] != good[:-1])) + 1
        for run in np.split(np.arange(len(values)), edges):
            if good[run[0]]:
                out, first = self._resampler[1].update(values[run], int(numbers[run[0]]))
                self._put(out.astype(np.float32), first, epoch, host, taken)
        if not good.all():
            self._unusable += int((~good).sum())
            share = self._output_rate / self._input_rate
            self._note(unusable_samples=round(self._unusable * share))
            self._drop(int(numbers[~good][-1]) + 1, epoch)

    def _drop(self, end: int, epoch: int) -> None:
        """Count the samples up to this number of the input as lost, until the next one is given.

        Raises
        ------
        InputError
            The source has never sent a usable sample.
        """
        until = -int(-end * self._output_rate // self._input_rate)
        with self._inbox.changed:
            self._begin_epoch(epoch, 0)
            self._pending = max(until - self._next[1], 0)
        self._wait()
        if not self._health.samples and self._silence >= REFUSED:
            raise InputError(
                f"{self.name} sends no usable sample ({end} are NaN, infinite, damaged or beyond "
                f"{LARGEST_SAMPLE:.3g}): check the sensor and the program that sends"
            )

    def _wait(self) -> bool:
        """Count the time without a usable sample. Return True if this is a silence.

        A source calls it each time that it looks at its line and finds nothing.
        """
        now = time.monotonic()
        self._silence += min(now - self._looked, LOOK)
        self._looked = now
        if self._silence >= SILENCE and self._health.connected:
            self._note(connected=False)
        return self._silence >= SILENCE

    def _put(
        self,
        data: NDArray[Any],
        first: int,
        epoch: int,
        host: float,
        taken: float | None = None,
    ) -> None:
        """Samples have come.

        Parameters
        ----------
        data
            Shape (samples, columns).
        first, epoch
            Number and epoch of the first.
        host
            When the last came, by the host's clock, s.
        taken
            When it was taken, where that is known better.

        Raises
        ------
        InputError
            The source has another rate than it states.
        """
        if not len(data):
            return
        self._silence, self._looked = 0.0, time.monotonic()
        with self._inbox.changed:
            self._begin_epoch(epoch, first)
            health, self._pending = self._health, 0
            lost = health.lost_samples + first - self._next[1]
            samples = health.samples + len(data)
            self._health = replace(health, connected=True, samples=samples, lost_samples=lost)
            markers = tuple(Marker(first, text, epoch) for text in self._words)
            self._words.clear()
            block = Block(data, first, epoch)
            self._inbox.put(Arrival(block, host, markers))
            self._next = (epoch, block.end)
            self._clock.add(block.end, host if taken is None else taken)
            self._inbox.wake()
        if self._rate_check.add(block.end, host):
            self._refuse_rate(self._rate_check.rate / self.descriptor.layout.rate, "this machine's")

    def _begin_epoch(self, epoch: int, first: int) -> None:
        """Begin an epoch with the sample of this number, unless it is going on; holds the lock."""
        if epoch == self._next[0]:
            return
        rate = self.descriptor.layout.rate
        self._clock, self._rate_check = ClockFit(rate), RateCheck(rate)
        health, lost = self._health, self._health.lost_samples + self._pending
        self._health = replace(
            health, epoch=epoch, reconnects=health.reconnects + 1, lost_samples=lost
        )
        self._next, self._pending = (epoch, first), 0

    def _refuse_rate(self, share: float, clock: str) -> NoReturn:
        """Refuse a source whose rate is this share of the stated one, by a clock."""
        stated = self._input_rate or self.descriptor.layout.rate
        raise InputError(
            f"{self.name} sends {share * stated:.0f} samples a second by {clock} clock, and its "
            f"rate is stated as {stated:.0f}: correct the stated rate, or what loses samples"
        )

    def _note(self, **counts: Any) -> None:
        """Set counts of the health."""
        with self._inbox.changed:
            self._health = replace(self._health, **counts)

    def _run(self) -> None:
        error: InputError | None = None
        try:
            self._work()
        except InputError as known:
            error = known
        except BaseException as unknown:
            # Whoever reads must not wait for a thread that is no more.
            _log.exception("%s: reading it failed", self.name)
            why = summarize_error(unknown)
            error = InputError(f"{self.name}: reading it failed ({why}): open it again")
        try:
            self._shut()
        except BaseException:
            _log.exception("%s: shutting it failed", self.name)
        with self._inbox.changed:
            self._inbox.end(error)
            self._part_with_words()
            self._health = replace(self._health, connected=False)
        _log.info("%s: closed; %s", self.name, self._health)

    def _part_with_words(self) -> None:
        """Give away the words whose sample will not come: with the last samples there were."""
        epoch, number = self._next
        markers = tuple(Marker(number, text, epoch) for text in self._words)
        self._words.clear()
        if markers:
            none = np.zeros((0, self.descriptor.layout.width), self.descriptor.dtype)
            self._inbox.attach(markers, (), Block(none, number, epoch))
