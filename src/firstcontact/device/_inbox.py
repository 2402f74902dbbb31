"""Queue of received samples between a source's thread and its reader."""

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
    """Queue with one writing and one reading thread."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.finished = False
        self.is_drained = False  # True once a reader got nothing after the end
        self.error: InputError | None = None
        self._arrivals: deque[Arrival] = deque()
        self._waiting = 0  # number of samples in the queue
        self._wanted = 0  # number of samples that a reader waits for, or 0
        self._raised = False  # True once a reader got the error

    @property
    def enough(self) -> bool:
        """Return True if a waiting reader can continue."""
        return self.finished or (bool(self._arrivals) and self._waiting >= self._wanted)

    @property
    def waiting(self) -> int:
        """Number of samples in the queue. Can be read without the lock."""
        return self._waiting

    def put(self, arrival: Arrival) -> None:
        """Append an arrival. Call :meth:`wake` afterwards to wake the reader."""
        self._arrivals.append(arrival)
        self._waiting += len(arrival.block.data)

    def wake(self) -> None:
        """Wake the reader if it can continue."""
        if self.enough:
            self.changed.notify_all()

    def attach(
        self, markers: tuple[Marker, ...], predictions: tuple[DevicePrediction, ...], empty: Block
    ) -> None:
        """Attach markers and predictions whose own samples are lost to the last samples."""
        last = self._arrivals.pop() if self._arrivals else Arrival(empty, time.monotonic())
        self._arrivals.append(
            replace(
                last, markers=last.markers + markers, predictions=last.predictions + predictions
            )
        )

    def end(self, error: InputError | None) -> None:
        """Mark the end of the stream. The reader gets ``error`` after the last samples."""
        self.error, self.finished = error, True
        self.changed.notify_all()

    @property
    def ended(self) -> bool:
        """True if the stream ended and all samples and errors were delivered. Takes the lock."""
        with self.changed:
            return self.finished and not self._arrivals and (self.error is None or self._raised)

    def read(self, timeout: float, least: int) -> list[Arrival]:
        """Return all samples received since the last call. Takes the lock."""
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
            self.is_drained = self.finished and not arrivals
            return arrivals
