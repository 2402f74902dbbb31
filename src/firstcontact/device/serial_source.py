"""Source for a device on a serial port."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Self

from firstcontact.core import DeviceError, InputError
from firstcontact.core.text import check_text
from firstcontact.device.assembler import Assembled, Assembler, Counts
from firstcontact.device.descriptor import Descriptor, DevicePrediction
from firstcontact.device.opening import SourceOptions
from firstcontact.device.ports import BAUD, LinkError, SerialTransport, not_a_port, reopen
from firstcontact.device.protocol import VERSION, FrameType, hint_payload, marker_text
from firstcontact.device.source import Arrival, Health
from firstcontact.device.threaded import LONGEST_PAUSE, QueuedSource
from firstcontact.device.twin_words import TWIN
from firstcontact.recording import Marker

_log = logging.getLogger("firstcontact.device")

#: Longest wait for the first answer after opening the port, s.
PATIENCE = 5.0
#: Time after a call of ``read`` at which the source's own thread begins to read the port, s. Until
#: then samples wait in the port, which holds 23 ms of them, and in the device (0.2 s or more).
READER_PAUSE = 0.04
#: Silence after which a device is asked whether it was reset, s. If it answers but sends no samples
#: for the same time again, it counts as disconnected ...
SILENCE = 1.0
#: ... and time without an answer after which the question is repeated.
AGAIN = 0.5
#: Longest wait for the end of the stream while data arrive, s.
FAREWELL = 10.0
#: Longest sleep while the reader waits for more samples, s, ...
NAP = 0.038
#: ... and time to wake up before they are due, s. A reader that waits for ``HURRY`` or longer wakes
#: up after the last frame instead, so that one read gets all samples.
EARLY, HURRY, FRAME = 0.0004, 0.005, 0.001
#: Size of a read, in bytes, after which the next read follows without a sleep. A pseudo terminal
#: holds 4095 bytes. While it is full, samples wait in the device.
PILE = 3800
#: Longest wait for a reader when the source ends, s.
LAST_TURN = 1.0
#: Time in the first epoch in which a wrong rate is refused, s.
OPENING = 5.0
#: Least time between samples whose rate is measured, s. Each frame of a closing comes by itself.
TIMED = 0.01
#: Sources without a real-time rate.
SIMULATED = ("twin", "synthetic")


# Not a ThreadedSource: here the thread also connects, and the device itself counts samples and
# places markers.
class SerialSource(QueuedSource):
    """Source for a device on a serial port, which may be unplugged and plugged in again.

    :meth:`read` reads the port in the caller's thread, so samples are available as soon as their
    last byte arrives. Between calls, a thread of the source reads the port and stores the samples.
    """

    #: Largest number of samples received ahead of the reader; None for no limit. Only a device that
    #: waits for its host loses nothing with a limit.
    most: int | None = None
    can_poll = True

    def __init__(self, port: str, patience: float = PATIENCE) -> None:
        super().__init__(port)
        self.port = port
        self._patience = patience
        self._transport: SerialTransport | None = None
        self._assembler = Assembler()
        self._began = 0.0  # arrival of the first samples of an epoch
        self._timed = 0.0  # time of the last samples whose rate was measured
        # The thread that holds this lock reads the port. The lock protects the next fields, too.
        self._turn = threading.Lock()
        self._opened = 0.0  # time at which the port was opened
        self._asked = -math.inf  # time of the last question to the device
        self._heard = 0.0  # time of the last samples or answer
        self._sampled = 0.0  # time of the last samples
        self._read_bytes = 0  # size of the last read
        self._last_read = -math.inf  # begin or end of the last call of ``read``
        self._interruption: Exception | None = None  # a reader's error, for the source's own thread
        # The fields below are protected by ``_changed``.
        self._markers: list[Marker] = []  # waiting for their sample
        self._predictions: list[DevicePrediction] = []  # waiting for the next samples
        self._connected = False

    @property
    def descriptor(self) -> Descriptor:
        if self._assembler.descriptor is None:
            raise self._not_open()
        return self._assembler.descriptor

    @property
    def health(self) -> Health:
        with self._changed:
            counts = {n: getattr(self._assembler.counts, n) for n in Counts.__slots__}
            counts["bad_frames"] = self._assembler.decoder.bad + counts.pop("malformed_frames")
            epoch, rate = max(self._assembler.epoch, 0), self._clock.rate
            return Health(self._connected, epoch, reconnects=epoch, host_rate=rate, **counts)

    def __enter__(self) -> Self:
        self._transport = SerialTransport(self.port)
        self._start()
        try:
            with self._changed:
                # Not for ``_connected``: a device that sends no samples may be disconnected again.
                self._changed.wait_for(lambda: self._assembler.epoch >= 0 or self._finished)
                if self._error is not None:
                    raise self._error
        except BaseException:
            self.close()
            raise
        return self

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        self._check_readable(timeout, is_drained=self._is_drained)
        until = time.monotonic() + timeout
        remaining = timeout
        self._last_read = until - timeout  # the source's own thread gives way
        if self._connected and self._turn.acquire(timeout=max(timeout, 0.0)):
            try:
                while self._connected and self._waiting < least:
                    self._read_port(least, remaining)
                    remaining = until - time.monotonic()
                    if remaining <= 0.0:
                        break
                self._last_read = time.monotonic()
            finally:
                self._turn.release()
        return self._collect(max(until - time.monotonic(), 0.0), least)

    def _read_port(self, least: int, patience: float) -> None:
        """Sleep until ``least`` samples should have arrived, then read the port once.

        :meth:`read` calls this method, in the caller's thread. The method returns after at most
        ``patience`` s.
        """
        transport = self._transport
        if transport is None or self._interruption is not None or self._closing.is_set():
            self._connected = False  # the source's own thread goes on
            return
        if patience > 0.0 and self._read_bytes < PILE:
            due = (least - self._waiting) / self.descriptor.layout.rate
            wait = due - EARLY if due < HURRY else due + FRAME
            nap = max(min(wait, NAP, patience), 0.0)
            if nap:
                time.sleep(nap)
            patience -= nap
        try:
            self._ask_and_read(transport, max(patience, 0.0))
        except Exception as error:
            self._interruption, self._connected = error, False

    def mark(self, text: str) -> None:
        check_text(text)
        if text.startswith(TWIN.strip()) and self.descriptor.source == "twin":
            raise DeviceError(
                f"a marker that begins with {TWIN.strip()!r} is reserved for the twin: "
                "begin with another word"
            )
        self._send(FrameType.MARK, marker_text(text), "the marker was not set")

    def order(self, text: str) -> None:
        self._send(FrameType.ORDER, marker_text(text), "the order was not given")

    def hint(self, speed: float, error: float, radius: float) -> None:
        """Send facts about the closing to the model that runs on the device.

        These are the closing speed, m/s, the relative standard error of the speed, and the radius
        of the object's surface, m. Raises DeviceError if the device is not connected.
        """
        self._send(FrameType.HINT, hint_payload(speed, error, radius), "the speed was not sent")

    def _send(self, kind: FrameType, payload: bytes, failed: str) -> None:
        transport = self._transport
        try:
            if transport is None:
                raise LinkError("closed")
            transport.send(kind, payload)
        except LinkError as error:
            raise DeviceError(
                f"{self.name}: the device is not connected, and {failed}: plug it in"
            ) from error

    def close(self) -> None:
        if not self._closing.is_set():
            _log.info("%s: closed; %s", self.name, self.health)
        super().close()

    def _run(self) -> None:
        """Receive samples until the source is closed. Connect again if the device was unplugged."""
        error: InputError | None = None
        try:
            while self._transport is not None:
                lost_port = self._transport
                try:
                    self._communicate(lost_port)
                    break
                except LinkError as lost:
                    if self._assembler.epoch < 0:
                        raise DeviceError(
                            "the device was unplugged while its port was opened: plug it in"
                        ) from lost
                self._disconnect()
                self._transport = reopen(lost_port, self._closing, BAUD)
        except InputError as input_error:
            error = DeviceError(f"{self.name}: {input_error}")
        except Exception as unexpected:
            # The reader must not wait for a thread that has ended.
            _log.exception("%s: reading failed", self.name)
            error = DeviceError(f"{self.name}: reading failed ({unexpected!r}): open it again")
        finally:
            with self._exclusive_port():  # a reader may be at the port
                self._connected = False
                transport, self._transport = self._transport, None
                if transport is not None:
                    transport.close()
            with self._changed:
                markers, self._markers = self._markers, []
                predictions, self._predictions = self._predictions, []
                number = markers[-1].sample if markers else self._assembler.next_sample
                self._end(error, markers, predictions, number, self._assembler.epoch)

    def _communicate(self, transport: SerialTransport) -> None:
        """Connect to the device. Then read its port in this thread, except while :meth:`read` does.

        Return once the source is closed. Raise LinkError if the port vanishes.
        """
        self._opened = time.monotonic()
        self._heard = self._asked = -math.inf
        while not self._closing.is_set():
            if self._interruption is not None:
                error, self._interruption = self._interruption, None
                raise error
            if not self._connected:
                with self._turn:
                    self._ask_and_read(transport)
            elif self._is_needed() and self._turn.acquire(blocking=False):
                try:
                    self._ask_and_read(transport)
                finally:
                    self._turn.release()
            else:
                elapsed = time.monotonic() - self._last_read
                time.sleep(READER_PAUSE - elapsed if elapsed < READER_PAUSE else READER_PAUSE)
        if self._assembler.epoch >= 0:
            with self._exclusive_port(), suppress(LinkError):
                self._stop(transport)

    @contextmanager
    def _exclusive_port(self) -> Iterator[None]:
        """Wait until :meth:`read` no longer reads the port, and keep it away in the ``with`` block.

        After ``LAST_TURN`` s, stop waiting.
        """
        has_turn = self._turn.acquire(timeout=LAST_TURN)
        try:
            yield
        finally:
            if has_turn:
                self._turn.release()

    def _ask_and_read(self, transport: SerialTransport, patience: float = math.inf) -> None:
        """Read the port once. If the device has been silent, first ask for its descriptor.

        Wait at most ``patience`` s for bytes. Raises DeviceError if the device has never answered.
        """
        now = time.monotonic()
        if now - self._heard > SILENCE and now - self._asked > AGAIN:
            if self._assembler.epoch < 0 and now - self._opened > self._patience:
                raise DeviceError(
                    "no device answers on this port: check that it is the fingertip "
                    "(`firstcontact ports --ask`), and flash its firmware"
                )
            with self._changed:
                # A device without a sample since the last question counts as disconnected.
                self._connected &= self._asked < self._sampled
            self._assembler.expect_descriptor()
            transport.send(FrameType.HELLO, bytes([VERSION]))
            self._asked = now
        data = transport.read(patience)
        self._read_bytes = len(data)
        if data and self._take(data, time.monotonic()).greeted:
            transport.send(FrameType.START)

    def _is_needed(self) -> bool:
        """Return True if the source's own thread must read the port.

        It need not if :meth:`read` was called just now, or if enough samples wait for the reader.
        """
        now = time.monotonic()
        if now - self._last_read < READER_PAUSE:
            return False
        if self.most is not None and self._waiting >= self.most:
            self._heard = now  # nothing is read meanwhile, so this is no silence
            return False
        return True

    def _take(self, data: bytes, now: float) -> Assembled:
        with self._changed:
            epoch = self._assembler.epoch
            assembled = self._assembler.feed(data)
            if self._assembler.epoch != epoch:
                d, rate = self.descriptor, self.descriptor.layout.rate
                values = (self._assembler.epoch, d.firmware, d.sensor, d.hand, d.source, rate)
                _log.info("%s: epoch %d of %r (%r, %r, %s, %g Hz)", self.name, *values)
                self._measure_rate(rate)
                self._began = math.inf
            self._markers += assembled.markers
            self._predictions += assembled.predictions
            for block in assembled.blocks:
                due: tuple[Marker, ...] = ()
                if self._markers:
                    end = block.epoch, block.end
                    due = tuple(m for m in self._markers if (m.epoch, m.sample) < end)
                    self._markers = [m for m in self._markers if (m.epoch, m.sample) >= end]
                predictions, self._predictions = tuple(self._predictions), []
                self._enqueue(Arrival(block, now, due, predictions=predictions))
            if (
                assembled.blocks
                and assembled.blocks[-1].epoch == self._assembler.epoch
                and now - self._timed > TIMED
            ):
                self._timed, newest = now, assembled.blocks[-1].end
                self._clock.add(newest, now)
                self._check_rate(newest, now)
            if assembled.blocks or self._assembler.epoch != epoch:
                self._sampled, self._connected = now, True
            if assembled.blocks or assembled.greeted:
                self._heard = now
                if assembled.greeted:  # ``__enter__`` waits for it
                    self._changed.notify_all()
                self._wake()
            return assembled

    def _check_rate(self, end: int, now: float) -> None:
        self._began = min(self._began, now)
        descriptor = self.descriptor
        has_pace = descriptor.paced and descriptor.source not in SIMULATED
        is_opening = self._assembler.epoch == 0 and now - self._began < OPENING
        if has_pace and is_opening and self._rate_check.add(end, now):
            raise DeviceError(
                f"the device sends {self._rate_check.rate:.0f} samples a second by this machine's "
                f"clock, but states a rate of {descriptor.layout.rate:.0f} Hz: correct the timer "
                "or the stated rate in its firmware"
            )

    def _disconnect(self) -> None:
        _log.info("%s: lost", self.name)
        with self._turn:
            with self._changed:
                self._connected = False
            transport, self._transport = self._transport, None
            self._interruption = None
        if transport is not None:
            transport.close()
        self._assembler.interrupted()

    def _stop(self, transport: SerialTransport) -> None:
        """Tell the device to stop. Receive samples until it confirms, or falls silent."""
        now = time.monotonic()
        silence, spent, last_request = 0.0, 0.0, -AGAIN
        while spent < FAREWELL and silence < SILENCE:
            if now - last_request > AGAIN:
                transport.send(FrameType.STOP)
                last_request = now
            data = transport.read()
            previous, now = now, time.monotonic()
            if self._take(data, now).stopped:
                return
            pause = min(now - previous, LONGEST_PAUSE)  # without a stop of this program
            spent += pause
            silence = 0.0 if self._heard == now else silence + pause


def from_port(port: str, options: SourceOptions) -> SerialSource:
    if reason := not_a_port(port):
        raise DeviceError(reason)
    options.check_own_speed(f"a device on {port}")
    return SerialSource(port)
