"""Samples that a source's thread has taken off its line, until somebody reads them."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import replace

from firstcontact.core import Block, InputError
from firstcontact.device._device_predictions import DevicePrediction
from firstcontact.device._source import Arrival
from firstcontact.recording import Marker


class Inbox:
    """One thread puts, another takes; what else both look at may be kept under its lock.

    All but :meth:`read`, :attr:`ended`, :attr:`missing` and :attr:`waiting` is called with
    :attr:`changed` held.
    """

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.finished = False
        self.error: InputError | None = None
        self._arrivals: deque[Arrival] = deque()
        self._waiting = 0  # samples in these
        self._wanted = 0  # samples that a reader waits for; 0 where none does
        self._raised = False  # the error, to a reader

    @property
    def enough(self) -> bool:
        """Whether a reader need not wait any longer."""
        return self.finished or (bool(self._arrivals) and self._waiting >= self._wanted)

    @property
    def waiting(self) -> int:
        """Samples that wait for a reader; may be looked at without the lock."""
        return self._waiting

    @property
    def missing(self) -> int:
        """Samples that a reader still waits for; may be looked at without the lock."""
        return self._wanted - self._waiting

    def put(self, arrival: Arrival) -> None:
        """Keep it; whoever waits is woken by :meth:`wake`."""
        self._arrivals.append(arrival)
        self._waiting += len(arrival.block.data)

    def wake(self) -> None:
        """Have a reader look, if there is enough."""
        if self.enough:
            self.changed.notify_all()

    def attach(
        self, markers: tuple[Marker, ...], predictions: tuple[DevicePrediction, ...], none: Block
    ) -> None:
        """Give away what no sample comes with any more: with the last samples there were.

        Parameters
        ----------
        markers, told
            These.
        none
            A block without samples, for where the last were read already.
        """
        last = self._arrivals.pop() if self._arrivals else Arrival(none, time.monotonic())
        self._arrivals.append(
            replace(
                last, markers=last.markers + markers, predictions=last.predictions + predictions
            )
        )

    def end(self, error: InputError | None) -> None:
        """Nothing more comes; an error is raised behind the last samples."""
        self.error, self.finished = error, True
        self.changed.notify_all()

    @property
    def ended(self) -> bool:
        """Whether nothing more will come, all was read and an error raised; takes the lock."""
        with self.changed:
            return self.finished and not self._arrivals and (self.error is None or self._raised)

    def read(self, timeout: float, least: int) -> list[Arrival]:
        """All that has come since the last call; takes the lock.

        Parameters
        ----------
        timeout
            Longest wait, s.
        least
            Samples that are waited for.

        Raises
        ------
        InputError
            The source is gone for good.
        """
        with self.changed:
            self._wanted = least
            self.changed.wait_for(lambda: self.enough, timeout)
            self._wanted = 0
            arrivals = list(self._arrivals)
            self._arrivals.clear()
            self._waiting = 0
            if not arrivals and self.error is not None:
                self._raised = True
                raise self.error
            return arrivals
