"""Sinks (outputs of a live session) and the threads that feed them."""

from __future__ import annotations

import logging
import math
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from firstcontact.device import Arrival, Descriptor, Health
from firstcontact.device.recorder import RecorderStatus
from firstcontact.streaming.events import Event

#: Largest number of updates that wait for a sink: 4 s at 50 updates per second.
WAITING = 200
#: Time between two checks of whether to wait any longer for a slow sink, s.
POLL = 0.05

_log = logging.getLogger("firstcontact.streaming")


@dataclass(frozen=True, slots=True, eq=False)
class Update:
    """New samples and events since the previous update, and the state of the live session."""

    arrivals: tuple[Arrival, ...] = ()
    events: tuple[Event, ...] = ()
    health: Health = field(default_factory=Health)
    recording: RecorderStatus = field(default_factory=RecorderStatus)
    #: Counts of pinches and blocks, and delays in s, such as "total_p50"; empty before a pinch.
    ledger: Mapping[str, float] = field(default_factory=dict)
    #: Outputs that failed since the last update: the reason by the name of the output.
    failed: Mapping[str, str] = field(default_factory=dict)


@runtime_checkable
class Sink(Protocol):
    """Output of a live session, such as a page or a text. Each sink runs in its own thread.

    A sink may be slow or fail: the session continues. Updates that do not fit in the sink's queue
    are dropped and counted. A sink for other programs sets ``is_prompt = True`` and gets each event
    immediately. Other sinks may get the events up to 50 ms late.
    """

    @property
    def name(self) -> str:
        """Name of the output in messages about dropped updates and failures."""

    @property
    def every(self) -> float:
        """Longest time that new samples may wait before :meth:`take` gets them, s."""

    def open(self, descriptor: Descriptor) -> None:
        """Open the output, for example its file or window, before the first update.

        ``descriptor`` describes the source: its names, sampling rate and channels. The session
        calls this method once, in the thread of the sink.
        """

    def take(self, update: Update) -> None:
        """Show or send an update: new samples, new events, and the state of the session."""

    def close(self) -> None:
        """Close the output. The session calls this once at its end, also after an error."""


class _Feeder:
    """Thread that passes updates to one sink. Its queue stores updates until the sink is ready."""

    def __init__(
        self, sink: Sink, descriptor: Descriptor, patient: bool, stopped: Callable[[], bool]
    ) -> None:
        self.sink = sink
        self.dropped = 0
        self.failed = ""
        self.left = False  # its reader went away, which is no fault
        self._descriptor = descriptor
        self._patient = patient
        self._stopped = stopped
        self._waiting: deque[Update] = deque()
        self._changed = threading.Condition()
        self._closing = False
        self._thread = threading.Thread(target=self._run, name=f"sink {sink.name}", daemon=True)
        self._thread.start()

    @property
    def _is_waiting(self) -> bool:
        return self._patient and not self._stopped()

    def put(self, update: Update) -> None:
        with self._changed:
            while len(self._waiting) >= WAITING and self._is_waiting:
                self._changed.wait(POLL)
            if self.failed:
                self.dropped += 1
                return
            # After a stop few updates follow, and a patient sink may still take all of them.
            if len(self._waiting) >= WAITING and not self._patient:
                # Drop the oldest: viewers want the newest state.
                self._waiting.popleft()
                self.dropped += 1
            self._waiting.append(update)
            self._changed.notify_all()

    def close(self, timeout: float) -> None:
        with self._changed:
            self._closing = True
            self._changed.notify()
        while self._thread.is_alive() and self._is_waiting:
            self._thread.join(POLL)
        self._thread.join(timeout)
        left = math.inf
        while self._patient and self._thread.is_alive() and len(self._waiting) < left:
            left = len(self._waiting)  # the sink is slow, and takes the rest
            self._thread.join(timeout)
        if self._thread.is_alive():
            # Do not wait any longer: the rest is lost, and counted.
            self._discard()

    def _discard(self) -> None:
        with self._changed:
            self.dropped += len(self._waiting)
            self._waiting.clear()
            self._changed.notify_all()

    def _run(self) -> None:
        try:
            self.sink.open(self._descriptor)
            while (update := self._next()) is not None:
                self.sink.take(update)
        except Exception as error:  # reported, and the other sinks go on
            with self._changed:
                self.failed = f"{type(error).__name__}: {error}"
                self.left = isinstance(error, BrokenPipeError)
            self._discard()
            _log.info("output %s failed: %s", self.sink.name, self.failed)
        finally:
            with suppress(Exception):
                self.sink.close()

    def _next(self) -> Update | None:
        with self._changed:
            while not self._waiting and not self._closing:
                self._changed.wait()
            update = self._waiting.popleft() if self._waiting else None
            self._changed.notify_all()
            return update


class Fanout:
    """Distributor that passes every update to every sink. Each sink has its own thread."""

    def __init__(
        self,
        sinks: Sequence[Sink],
        descriptor: Descriptor,
        patient: bool = False,
        stopped: Callable[[], bool] = lambda: False,
    ) -> None:
        self._feeders = [_Feeder(sink, descriptor, patient, stopped) for sink in sinks]

    def put(self, update: Update) -> None:
        for feeder in self._feeders:
            feeder.put(update)

    @property
    def dropped(self) -> dict[str, int]:
        """Number of updates that each sink missed, by its name.

        Sinks whose reader left do not count.
        """
        return {f.sink.name: f.dropped for f in self._feeders if not f.left}

    @property
    def failed(self) -> dict[str, str]:
        """Reason why each failed sink failed, by its name. Sinks whose reader left do not count."""
        return {f.sink.name: f.failed for f in self._feeders if f.failed and not f.left}

    @property
    def deserted(self) -> bool:
        """True if there are sinks, and all of them have failed or lost their readers."""
        return bool(self._feeders) and all(f.failed for f in self._feeders)

    def close(self, timeout: float = 2.0) -> None:
        for feeder in self._feeders:
            feeder.close(timeout)
