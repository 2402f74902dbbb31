"""What sources have in common whose samples a thread of their own takes off a line."""

from __future__ import annotations

import logging
import threading
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Block, InputError
from firstcontact.core.foreign import in_a_line
from firstcontact.device._inbox import Inbox
from firstcontact.device.clock import ClockFit
from firstcontact.device.source import Arrival, Descriptor, Health
from firstcontact.recording import Marker

_log = logging.getLogger(__name__)


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
            return replace(self._health, host_rate=self._clock.rate)

    @property
    def ended(self) -> bool:
        """Whether nothing more will come, all was read and every error told."""
        return self._inbox.ended

    def __enter__(self) -> Self:
        self._descriptor = self._open()
        self._clock = ClockFit(self._descriptor.layout.rate)
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
        """
        if not len(data):
            return
        with self._inbox.changed:
            health = self._health
            if epoch != self._next[0]:
                self._clock = ClockFit(self.descriptor.layout.rate)
                health = replace(health, epoch=epoch, reconnects=health.reconnects + 1)
            else:
                health = replace(health, lost_samples=health.lost_samples + first - self._next[1])
            self._health = replace(health, connected=True, samples=health.samples + len(data))
            markers = tuple(Marker(first, text, epoch) for text in self._words)
            self._words.clear()
            block = Block(data, first, epoch)
            self._inbox.put(Arrival(block, host, markers))
            self._next = (epoch, block.end)
            self._clock.add(block.end, host if taken is None else taken)
            self._inbox.wake()

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
            why = in_a_line(unknown)
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
