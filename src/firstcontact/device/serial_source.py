"""A device on a serial port as a source of samples."""

from __future__ import annotations

import threading
import time
from collections import deque
from contextlib import suppress
from types import TracebackType
from typing import Self

from firstcontact.core import InputError
from firstcontact.device.assembler import Assembled, Assembler
from firstcontact.device.clock import ClockFit
from firstcontact.device.decoder import Decoder
from firstcontact.device.handshake import greet
from firstcontact.device.protocol import FrameType, marker_text
from firstcontact.device.source import Arrival, Descriptor, Health
from firstcontact.device.transport import LinkError, SerialTransport
from firstcontact.recording import Marker

#: Waits between attempts to open a port that is gone, s: twice as long each time.
RETRY = (0.05, 1.0)
#: A device that sends nothing for so long is asked whether it is still the same, s.
SILENCE = 1.0
#: How long the end of the stream is waited for when it is closed, s.
FAREWELL = 1.0


class SerialSource:
    """A device on a port; it may be unplugged and come back.

    One thread reads the port, whatever the reader of :meth:`read` does, and keeps
    what has come until it is read. A port that comes back begins a new epoch; so
    does a device that was reset without losing its port, which shows as silence.

    Parameters
    ----------
    port
        Its path or name.

    Raises
    ------
    InputError
        On entering: the port cannot be opened, is in use, or what is on it does
        not answer or speaks another version.
    """

    def __init__(self, port: str) -> None:
        self.port = port
        self._transport: SerialTransport | None = None
        self._descriptor: Descriptor | None = None
        self._assembler: Assembler | None = None
        self._decoder = Decoder()
        self._bad = 0  # of decoders before this one
        self._clock = ClockFit(1.0)
        self._changed = threading.Condition()
        self._arrivals: deque[Arrival] = deque()
        self._markers: list[Marker] = []  # that wait for their sample
        self._error: InputError | None = None
        self._connected = False
        self._reconnects = 0
        self._stopping = threading.Event()
        self._thread: threading.Thread | None = None
        self._sending = threading.Lock()
        self._heard = 0.0

    @property
    def name(self) -> str:
        """The port."""
        return self.port

    @property
    def descriptor(self) -> Descriptor:
        """What the device says about itself."""
        if self._descriptor is None:
            raise InputError(f"{self.port} is not open: enter the source first")
        return self._descriptor

    @property
    def health(self) -> Health:
        """Counts up to now."""
        with self._changed:
            assembler = self._assembler
            if assembler is None:
                return Health()
            c = assembler.counts
            return Health(
                connected=self._connected,
                epoch=max(assembler.epoch, 0),
                samples=c.samples,
                lost_samples=c.lost_samples,
                overflow_samples=c.overflow_samples,
                lost_frames=c.lost_frames,
                bad_frames=self._bad + self._decoder.bad + c.malformed_frames,
                doubled_frames=c.doubled_frames,
                reconnects=self._reconnects,
                host_rate=self._clock.rate,
            )

    @property
    def ended(self) -> bool:
        """Whether it was closed and all was read."""
        with self._changed:
            return self._stopping.is_set() and not self._alive and not self._arrivals

    @property
    def _alive(self) -> bool:
        return self._thread is not None and self._thread.is_alive()

    def __enter__(self) -> Self:
        transport = SerialTransport(self.port)
        try:
            greeting = greet(transport)
        except (LinkError, InputError) as error:
            transport.close()
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"{self.port} went away while it was being opened: plug it in"
            ) from None
        self._transport = transport
        self._descriptor = greeting.descriptor
        layout = greeting.descriptor.layout
        self._assembler = Assembler(len(layout.channels))
        self._clock = ClockFit(layout.rate)
        self._assembler.begin(greeting.boot)
        self._connected = True
        self._heard = time.monotonic()
        self._thread = threading.Thread(target=self._run, name=f"reader {self.port}", daemon=True)
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def read(self, timeout: float) -> list[Arrival]:
        """All that has come since the last call, waiting up to ``timeout`` s for something."""
        with self._changed:
            if not self._arrivals and self._error is None and self._alive:
                self._changed.wait_for(
                    lambda: self._arrivals or self._error is not None or not self._alive, timeout
                )
            arrivals = list(self._arrivals)
            self._arrivals.clear()
            if not arrivals and self._error is not None:
                raise self._error
            return arrivals

    def mark(self, text: str) -> None:
        """Have a word pinned to the next sample.

        Raises
        ------
        InputError
            The device is not there.
        """
        try:
            self._send(FrameType.MARK, marker_text(text))
        except LinkError:
            raise InputError(
                f"{self.port}: the device is not there, the marker was not set: plug it in"
            ) from None

    def close(self) -> None:
        """Stop the device, take what it still sends, and let go of the port."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
        if self._transport is not None:
            self._transport.close()
            self._transport = None

    def _send(self, kind: FrameType, payload: bytes = b"") -> None:
        with self._sending:
            if self._transport is None:
                raise LinkError("closed")
            self._transport.send(kind, payload)

    def _run(self) -> None:
        """Read until closed; whatever goes wrong for good is raised by :meth:`read`."""
        try:
            with suppress(LinkError):
                self._send(FrameType.START)
            while not self._stopping.is_set():
                try:
                    self._pump()
                except LinkError:
                    self._lost()
                    self._return()
            with suppress(LinkError):
                self._farewell()
        except InputError as error:
            with self._changed:
                self._error = error
        finally:
            with self._changed:
                self._connected = False
                self._changed.notify_all()

    def _pump(self) -> None:
        """Take what the port has; ask a device that has gone silent who it is."""
        assert self._transport is not None
        data = self._transport.read()
        now = time.monotonic()
        if data:
            self._take(data, now)
        elif now - self._heard > SILENCE:
            try:
                self._again(interrupted=False)
            except _ChangedError:
                raise
            except InputError:  # no answer yet: asked again when it was silent for as long
                with self._changed:
                    self._connected = False
                    self._heard = time.monotonic()

    def _take(self, data: bytes, now: float) -> Assembled:
        assert self._assembler is not None
        with self._changed:
            out = self._assembler.take(self._decoder.feed(data))
            counts = self._assembler.counts
            if counts.malformed_frames and not counts.samples:
                raise InputError(
                    f"{self.port}: samples do not have the columns of the device's layout: flash "
                    "the firmware that belongs to this version of firstcontact"
                )
            # A marker belongs to a sample that comes after it.
            self._markers += out.markers
            for block in out.blocks:
                markers, self._markers = tuple(self._markers), []
                self._arrivals.append(Arrival(block, now, markers))
            if out.blocks:
                self._heard = now
                self._clock.add(out.blocks[-1].end, now)
                self._changed.notify_all()
            return out

    def _lost(self) -> None:
        with self._changed:
            self._connected = False
            self._bad += self._decoder.bad
            self._decoder = Decoder()
        with self._sending:
            if self._transport is not None:
                self._transport.close()
                self._transport = None

    def _return(self) -> None:
        """Wait for the port to come back."""
        wait, longest = RETRY
        while not self._stopping.wait(wait):
            wait = min(2 * wait, longest)
            try:
                transport = SerialTransport(self.port)
            except InputError:
                continue
            self._transport = transport
            try:
                self._again(interrupted=True)
            except _ChangedError:
                raise
            except (LinkError, InputError):
                # Not there yet, or busy starting.
                with self._sending:
                    transport.close()
                    self._transport = None
                continue
            return

    def _again(self, *, interrupted: bool) -> None:
        """Shake hands anew with a device that came back or fell silent."""
        assert self._transport is not None
        assert self._assembler is not None
        with self._sending:
            greeting = greet(self._transport)
        if greeting.descriptor.layout != self.descriptor.layout:
            raise _ChangedError(
                f"{self.port}: another device is plugged in, with another layout: start again"
            )
        with self._changed:
            before = self._assembler.epoch
            self._assembler.begin(greeting.boot, interrupted=interrupted)
            if self._assembler.epoch != before:
                self._clock.reset()
                self._reconnects += 1
            self._connected = True
            self._heard = time.monotonic()
        self._send(FrameType.START)

    def _farewell(self) -> None:
        """Stop, and take what comes until the device says that this was all."""
        assert self._transport is not None
        self._send(FrameType.STOP)
        until = time.monotonic() + FAREWELL
        while time.monotonic() < until:
            if self._take(self._transport.read(), time.monotonic()).stopped:
                return


class _ChangedError(InputError):
    """Another device than before."""
