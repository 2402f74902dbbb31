"""A device on a serial port as a source of samples."""

from __future__ import annotations

import logging
import math
import threading
import time
from contextlib import suppress
from typing import Self

import numpy as np

from firstcontact.core import Block, InputError
from firstcontact.device._assembler import Assembled, Assembler
from firstcontact.device._clock import ClockFit
from firstcontact.device._decoder import Decoder
from firstcontact.device._device_predictions import DevicePrediction
from firstcontact.device._inbox import Inbox
from firstcontact.device._opening import SourceOptions
from firstcontact.device._protocol import VERSION, FrameType, marker_text
from firstcontact.device._source import Arrival, Descriptor, Health
from firstcontact.device._stream_checks import RateCheck
from firstcontact.device._transport import LinkError, SerialTransport, no_port
from firstcontact.device._twin_words import TWIN
from firstcontact.recording import Marker

_log = logging.getLogger(__name__)

#: What does not answer for so long after its port was opened is no device of ours, s.
PATIENCE = 5.0
#: How often it is looked whether a reader has taken what waits, s.
LOOK = 2e-3
#: A device that sends no samples for so long is asked whether it was reset, s. One that answers and
#: sends no samples for as long again is not connected ...
SILENCE = 1.0
#: ... and again after so long without an answer.
AGAIN = 0.5
#: Waits between attempts to open a port that is gone, s: twice as long each time.
RETRY = (0.05, 1.0)
#: The end of the stream is waited for while something comes, and at most so long, s.
FAREWELL = 10.0
#: While its reader waits for more samples, the port is left alone: so long at most, s, ...
NAP = 0.02
#: ... and up to so long before they are due, for waking up.
EARLY = 0.0004
#: A device whose rate is wrong is refused in this phase of its first epoch, s. Later, in the middle
#: of a session, a warning is logged.
OPENING = 5.0
#: Sources whose samples take as long as they take to compute.
SIMULATED = ("twin", "synthetic")
#: Bytes of a read after which nothing is waited for: it comes faster than its rate says.
PILE = 4096


# No ThreadedSource: its thread connects, too; the device itself counts samples and places words.
class SerialSource:
    """A device on a port; it may be unplugged and come back.

    One thread reads the port, whatever the reader of :meth:`read` does, and keeps
    what has come until it is read. A port that comes back begins a new epoch, even if
    the device was never without power; so does a device that was reset without
    losing its port, which shows as silence. What a device that kept its power
    sampled meanwhile is counted as lost.

    Parameters
    ----------
    port
        Its path or name.
    patience
        How long to wait for an answer when it is opened, s.

    Raises
    ------
    InputError
        On entering: the port cannot be opened, is in use, or what is on it does
        not answer, speaks another version or cannot be used.
    """

    #: Samples that are taken off the line before a reader takes them; None for all that come. Only
    #: a device that waits for its host loses nothing by a number.
    most: int | None = None

    def __init__(self, port: str, patience: float = PATIENCE) -> None:
        self.port = port
        self._patience = patience
        self._transport: SerialTransport | None = None
        self._decoder = Decoder()
        self._assembler = Assembler()
        self._clock = ClockFit(1.0)
        self._rate_check = RateCheck(1.0)
        self._began = 0.0  # when the first samples of an epoch came
        self._has_warned = False  # of the rate, in this epoch
        self._thread: threading.Thread | None = None
        self._closing = threading.Event()
        self._heard = 0.0  # when samples or an answer came last
        self._sampled = 0.0  # when samples came last
        self._inbox = Inbox()
        # What follows is changed and looked at with its lock.
        self._markers: list[Marker] = []  # that wait for their sample
        self._predictions: list[DevicePrediction] = []  # that wait for samples to come with
        self._connected = False

    @property
    def name(self) -> str:
        """The port."""
        return self.port

    @property
    def descriptor(self) -> Descriptor:
        """What the device says about itself."""
        if self._assembler.descriptor is None:
            raise InputError(f"{self.name} is not open: enter the source first")
        return self._assembler.descriptor

    @property
    def health(self) -> Health:
        """Counts up to now."""
        with self._inbox.changed:
            counts = self._assembler.counts
            epoch = max(self._assembler.epoch, 0)
            return Health(
                connected=self._connected,
                epoch=epoch,
                samples=counts.samples,
                lost_samples=counts.lost_samples,
                overflow_samples=counts.overflow_samples,
                lost_frames=counts.lost_frames,
                bad_frames=self._decoder.bad + counts.malformed_frames,
                doubled_frames=counts.doubled_frames,
                late_answers=counts.late_answers,
                unheard_samples=counts.unheard_samples,
                reconnects=epoch,
                host_rate=self._clock.rate,
            )

    @property
    def ended(self) -> bool:
        """Whether it was closed and all was read, or has failed and :meth:`read` has said so."""
        return self._inbox.ended

    def __enter__(self) -> Self:
        self._transport = SerialTransport(self.port)
        self._thread = threading.Thread(target=self._run, name=f"reader {self.port}", daemon=True)
        self._thread.start()
        try:
            with self._inbox.changed:
                self._inbox.changed.wait_for(lambda: self._connected or self._inbox.finished)
                if self._inbox.error is not None:
                    raise self._inbox.error
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """All that has come since the last call, waiting up to ``timeout`` s for so much."""
        return self._inbox.read(timeout, least)

    def mark(self, text: str) -> None:
        """Have a word pinned to the next sample.

        Raises
        ------
        InputError
            The device is not there, or the word is one that only the twin says.
        """
        if text.startswith(TWIN.strip()) and self.descriptor.source == "twin":
            raise InputError(
                f"a marker that begins with {TWIN.strip()!r} is the twin's own: "
                "begin yours with another word"
            )
        self._tell(FrameType.MARK, text, "the marker was not set")

    def order(self, text: str) -> None:
        """Tell a simulated hand what to do; a device that is none takes no notice.

        Raises
        ------
        InputError
            The device is not there.
        """
        self._tell(FrameType.ORDER, text, "the order was not given")

    def _tell(self, kind: FrameType, text: str, failed: str) -> None:
        transport = self._transport
        try:
            if transport is None:
                raise LinkError("closed")
            transport.send(kind, marker_text(text))
        except LinkError as error:
            raise InputError(
                f"{self.name}: the device is not there and {failed}: plug it in"
            ) from error

    def close(self) -> None:
        """Stop the device, take what it still sends, and let go of the port.

        What was taken can still be read. Closing twice is fine.
        """
        if not self._closing.is_set():
            _log.info("%s: closed; %s", self.name, self.health)
        self._closing.set()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        """Read until closed; what goes wrong for good is raised by :meth:`read`."""
        error: InputError | None = None
        try:
            while self._transport is not None:
                try:
                    self._converse(self._transport)
                    break
                except LinkError as lost:
                    if self._assembler.epoch < 0:
                        raise InputError("it went away while it was opened: plug it in") from lost
                self._lost()
                self._transport = self._reopened()
        except InputError as known:
            error = InputError(f"{self.name}: {known}")
        except Exception as unknown:
            # Whoever reads must not wait for a thread that is no more.
            _log.exception("%s: reading it failed", self.name)
            error = InputError(f"{self.name}: reading it failed ({unknown!r}): open it again")
        finally:
            transport, self._transport = self._transport, None
            if transport is not None:
                transport.close()
            with self._inbox.changed:
                self._connected = False
                self._inbox.end(error)
                self._part_with_markers()

    def _converse(self, transport: SerialTransport) -> None:
        """Ask who is there, have it send, and take what comes until closed."""
        opened = now = time.monotonic()
        self._heard = asked = -math.inf
        while not self._closing.is_set():
            if now - self._heard > SILENCE and now - asked > AGAIN:
                if self._assembler.epoch < 0 and now - opened > self._patience:
                    raise InputError(
                        "what is on this port does not answer: check that it is the fingertip "
                        "(`firstcontact ports --ask`), and flash its firmware"
                    )
                with self._inbox.changed:
                    # No sample since the last question is as good as no device.
                    self._connected &= asked < self._sampled
                self._assembler.asked()
                transport.send(FrameType.HELLO, bytes([VERSION]))
                asked = now
            data = transport.read()
            now = time.monotonic()
            if self._take(data, now).greeted:
                transport.send(FrameType.START)
            if self._wait_for_reader():
                self._heard = now = time.monotonic()  # nobody listened: that was no silence
            elif len(data) < PILE:
                self._nap()
                now = time.monotonic()
        if self._assembler.epoch >= 0:
            with suppress(LinkError):
                self._farewell(transport)

    def _wait_for_reader(self) -> bool:
        """Leave what comes on the line while enough waits here; whether that was so."""
        waited = False
        while (
            self.most is not None
            and self._inbox.waiting >= self.most
            and self._inbox.missing <= 0
            and not self._closing.wait(LOOK)
        ):
            waited = True
        return waited

    def _nap(self) -> None:
        """Leave the port alone while what has come and comes next is worth no wake-up."""
        descriptor = self._assembler.descriptor
        if descriptor is None or not self._connected:
            return
        nap = min(self._inbox.missing / descriptor.layout.rate - EARLY, NAP)
        if nap > 0.0:
            time.sleep(nap)

    def _take(self, data: bytes, now: float) -> Assembled:
        with self._inbox.changed:
            epoch = self._assembler.epoch
            out = self._assembler.take(self._decoder.feed(data))
            if self._assembler.epoch != epoch:
                said = self.descriptor
                _log.info(
                    "%s: life %d of %r (%r, %r, %s, %g Hz)",
                    self.name,
                    self._assembler.epoch,
                    said.firmware,
                    said.sensor,
                    said.hand,
                    said.source,
                    said.layout.rate,
                )
                rate = said.layout.rate
                self._clock, self._rate_check = ClockFit(rate), RateCheck(rate)
                self._began, self._has_warned = math.inf, False
            self._markers += out.markers
            self._predictions += out.predictions
            for block in out.blocks:
                due = self._due(block.epoch, block.end)
                predictions = tuple(self._predictions)
                self._predictions = []
                self._inbox.put(Arrival(block, now, due, predictions=predictions))
            if out.blocks and out.blocks[-1].epoch == self._assembler.epoch:
                self._clock.add(out.blocks[-1].end, now)
                self._check_rate(out.blocks[-1].end, now)
            if out.blocks or self._assembler.epoch != epoch:
                self._sampled, self._connected = now, True
            if out.blocks or out.greeted:
                self._heard = now
                if out.greeted:  # who entered waits for it
                    self._inbox.changed.notify_all()
                self._inbox.wake()
            return out

    def _check_rate(self, end: int, now: float) -> None:
        """Hold the rate of a device that sends in real time against the one that it states.

        Raises
        ------
        InputError
            It differs, and the device was opened just now.
        """
        self._began = min(self._began, now)
        descriptor = self.descriptor
        if not descriptor.paced or descriptor.source in SIMULATED or self._has_warned:
            return
        if not self._rate_check.add(end, now):
            return
        message = (
            f"the device sends {self._rate_check.rate:.0f} samples a second by this machine's "
            f"clock, and its rate is stated as {descriptor.layout.rate:.0f}: correct the timer or "
            "the stated rate of its firmware"
        )
        if self._assembler.epoch == 0 and now - self._began < OPENING:
            raise InputError(message)
        self._has_warned = True
        _log.warning("%s: %s", self.name, message)

    def _due(self, epoch: int, end: int) -> tuple[Marker, ...]:
        """Take the markers that belong to samples before this one."""
        due = tuple(m for m in self._markers if (m.epoch, m.sample) < (epoch, end))
        if due:
            self._markers = [m for m in self._markers if m not in due]
        return due

    def _part_with_markers(self) -> None:
        """Give away markers and answers that no sample comes with: with the last there were."""
        markers, self._markers = tuple(self._markers), []
        predictions, self._predictions = tuple(self._predictions), []
        descriptor = self._assembler.descriptor
        if not (markers or predictions) or descriptor is None:
            return
        epoch, next_sample = self._assembler.epoch, self._assembler.next_sample
        number = markers[-1].sample if markers else next_sample
        none = np.zeros((0, descriptor.layout.width), np.int16)
        self._inbox.attach(markers, predictions, Block(none, number, epoch))

    def _lost(self) -> None:
        _log.info("%s: lost", self.name)
        with self._inbox.changed:
            self._connected = False
        transport, self._transport = self._transport, None
        if transport is not None:
            transport.close()
        self._decoder.restart()
        self._assembler.interrupted()

    def _reopened(self) -> SerialTransport | None:
        """The port when it is there again; None when closed before that."""
        wait, longest = RETRY
        while not self._closing.wait(wait):
            wait = min(2 * wait, longest)
            # Gone, not yet accessible, or taken by another program for a moment.
            with suppress(InputError):
                return SerialTransport(self.port)
        return None

    def _farewell(self, transport: SerialTransport) -> None:
        """Stop, and take what comes until the device says that this was all."""
        now = time.monotonic()
        self._heard, until, asked = now, now + FAREWELL, -AGAIN
        while now < until and now - self._heard < SILENCE:
            if now - asked > AGAIN:
                transport.send(FrameType.STOP)
                asked = now
            data = transport.read()
            now = time.monotonic()
            if self._take(data, now).stopped:
                return


def from_port(port: str, options: SourceOptions) -> SerialSource:
    """The device on a port; InputError where a speed is asked of it, or it can be no port."""
    if why := no_port(port):
        raise InputError(why)
    options.check_own_speed(f"a device on {port}")
    return SerialSource(port)
