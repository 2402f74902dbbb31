"""Assembler of the frames (packets) from a device into numbered samples, with counts of losses."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from firstcontact.core import Block, DeviceError
from firstcontact.device.descriptor import (
    Descriptor,
    DevicePrediction,
    check_place,
    read_contact,
    read_estimate,
    read_greeting,
    refusal,
)
from firstcontact.device.protocol import (
    Decoder,
    Frame,
    FrameError,
    FrameType,
    NextSamples,
    read_late,
    read_marker,
    read_stopped,
    samples_head,
)
from firstcontact.recording import Marker

_WRAP = 1 << 32
#: Largest distance of a device's prediction from the newest sample, s. It allows for a host that
#: did not read for a while.
FARTHEST = 60.0


@dataclass(slots=True)
class Counts:
    """Counts of received and lost data, with the names of :class:`~firstcontact.Health`.

    ``malformed_frames`` counts frames that arrived intact but have impossible content.
    """

    samples: int = 0
    lost_samples: int = 0
    overflow_samples: int = 0
    lost_frames: int = 0
    doubled_frames: int = 0
    malformed_frames: int = 0
    late_answers: int = 0
    unheard_samples: int = 0


@dataclass(slots=True, eq=False)
class Assembled:
    """Content of some received frames: blocks, markers and predictions, each in order.

    ``greeted`` is True if the frames contained a new descriptor, and ``stopped`` if they contained
    the device's confirmation that it stopped.
    """

    blocks: list[Block] = field(default_factory=list)
    markers: list[Marker] = field(default_factory=list)
    predictions: list[DevicePrediction] = field(default_factory=list)
    greeted: bool = False
    stopped: bool = False


class Assembler:
    """Assembler of a device's bytes into blocks of samples with continuous numbers.

    Each connection after :meth:`interrupted` begins a new epoch, and so does each restart of the
    device. A restart shows as a new boot number in the descriptor, or as a lower frame counter in a
    requested descriptor. After a restart, samples count from 0. Without a restart, the samples that
    the device sent meanwhile count as lost.
    """

    def __init__(self) -> None:
        self.decoder = Decoder()
        self.counts = Counts()
        self.epoch = -1  #: Epoch of the next samples; -1 before the first descriptor.
        self.descriptor: Descriptor | None = None
        self._width = 0  # channels of a sample, cached for speed
        self._listening = False  # True after a descriptor on this connection
        self._descriptor_requested = False
        self._samples_received = False  # True after samples on this connection
        self._fits = False  # True after a samples frame with the layout's columns
        self._boot = 0
        self._counter: int | None = None
        self._next: int | None = None
        self._overflow: int | None = None
        # Number of predictions that the device skipped since its start, and of missed samples.
        self._late: tuple[int, int] | None = None
        self._run: list[bytes] = []  # consecutive samples ...
        self._run_first = 0  # ... and the number of the first one

    @property
    def next_sample(self) -> int:
        return self._next or 0

    def expect_descriptor(self) -> None:
        self._descriptor_requested = True

    def interrupted(self) -> None:
        """Note that the connection was lost. Ignore frames until the next descriptor."""
        self._listening = False
        self.decoder.restart()

    def feed(self, data: bytes) -> Assembled:
        """Process the next bytes from the device. Return the content of the completed frames."""
        if not self._fits or not self._listening:
            return self.take(self.decoder.feed(data))
        assert self._counter is not None
        assert self._next is not None
        assert self._overflow is not None
        expected = NextSamples(self._width, self._counter, self._next, self._overflow)
        frames, samples = self.decoder.feed_samples(data, expected)
        if frames:
            n = len(samples) // (2 * self._width)
            if not self._run:
                self._run_first = self._next
            self._run.append(samples)
            self._counter += frames
            self._next += n
            self._samples_received = True
            self.counts.samples += n
        return self.take(self.decoder.feed(b""))

    def take(self, frames: list[Frame]) -> Assembled:
        assembled = Assembled()
        for frame in frames:
            try:
                if frame.type == FrameType.DESCRIPTOR:
                    self._flush(assembled)
                    assembled.greeted |= self._accept_descriptor(frame)
                elif frame.type == FrameType.REFUSED:
                    raise refusal(frame.payload)
                elif self._listening and self._accept_counter(frame.counter):
                    self._content(frame, assembled)
            except FrameError as error:
                self.counts.malformed_frames += 1
                if frame.type == FrameType.SAMPLES and not self._fits:
                    raise DeviceError(
                        f"the device's samples do not fit its descriptor ({error}): flash the "
                        "firmware that belongs to this version of firstcontact"
                    ) from error
        self._flush(assembled)
        return assembled

    def _accept_descriptor(self, frame: Frame) -> bool:
        """Process a descriptor. Return True if it is accepted, False if it is late or repeated.

        Raises DeviceError if the layout differs from that of the first descriptor.
        """
        boot, descriptor = read_greeting(frame.payload)
        if self.descriptor is None:
            self.descriptor = descriptor
            self._width = descriptor.layout.width
        elif descriptor.layout != self.descriptor.layout:
            raise DeviceError(
                "another device is now on this port, with other channels or another sampling "
                "rate: start the command again to use this device"
            )
        counter_went_back = self._counter is not None and self._count_missing(frame.counter) < 0
        restarted = (
            self.epoch < 0
            or boot != self._boot
            or (counter_went_back and self._descriptor_requested)
        )
        self._descriptor_requested = False
        if restarted:
            self._counter = self._next = self._overflow = self._late = None
            self._fits = False
            self._boot = boot
        if not self._accept_counter(frame.counter):
            return False
        if restarted or not self._listening:
            self.epoch += 1
        self._listening, self._samples_received = True, False
        return True

    def _content(self, frame: Frame, assembled: Assembled) -> None:
        if frame.type == FrameType.SAMPLES:
            self._samples(frame.payload, assembled)
        elif frame.type == FrameType.MARKER:
            sample, text = read_marker(frame.payload)
            assembled.markers.append(Marker(self._unwrapped(sample), text, self.epoch))
        elif frame.type in (FrameType.CONTACT, FrameType.WITHDRAWN):
            is_withdrawn = frame.type == FrameType.WITHDRAWN
            contact = read_contact(frame.payload, self.epoch, withdrawn=is_withdrawn)
            sample, decided = self._unwrapped(contact.sample), self._unwrapped(contact.decided)
            self._add_prediction(replace(contact, sample=sample, decided=decided), assembled)
        elif frame.type == FrameType.ESTIMATE:
            estimate = read_estimate(frame.payload, self.epoch)
            sample, decided = self._unwrapped(estimate.contact), self._unwrapped(estimate.decided)
            self._add_prediction(replace(estimate, contact=sample, decided=decided), assembled)
        elif frame.type == FrameType.LATE:
            self._count_late(*read_late(frame.payload))
        elif frame.type == FrameType.STOPPED:
            self._account(*read_stopped(frame.payload))
            assembled.stopped = True

    def _add_prediction(self, prediction: DevicePrediction, assembled: Assembled) -> None:
        """Add the device's contact or estimate to ``assembled``.

        Raises FrameError if the prediction's sample numbers are impossible.
        """
        assert self.descriptor is not None
        newest = (
            self._next if self._next is not None and self._samples_received else prediction.decided
        )
        check_place(prediction, newest, round(FARTHEST * self.descriptor.layout.rate))
        assembled.predictions.append(prediction)

    def _count_missing(self, counter: int) -> int:
        """Return the number of frames missing before frame ``counter``.

        It is negative if a frame with this number has already arrived.
        """
        assert self._counter is not None
        ahead = (counter - self._counter) % _WRAP
        return ahead if ahead < _WRAP // 2 else ahead - _WRAP

    def _accept_counter(self, counter: int) -> bool:
        if self._counter is not None:
            ahead = self._count_missing(counter)
            if ahead < 0:
                self.counts.doubled_frames += 1
                return False
            self.counts.lost_frames += ahead
        self._counter = counter + 1
        return True

    def _samples(self, payload: bytes, assembled: Assembled) -> None:
        sample, overflow, n, data = samples_head(payload, self._width)
        self._fits = True
        expected = self._next
        first = self._account(sample, overflow)
        if first is None:
            self.counts.doubled_frames += 1
            return
        if first != expected:
            self._flush(assembled)
            self._run_first = first
        elif not self._run:
            self._run_first = first
        self._run.append(data)
        self._next = first + n
        self.counts.samples += n

    def _account(self, sample: int, overflow: int) -> int | None:
        number = self._unwrapped(sample)
        if self._next is not None:
            if number < self._next:
                return None
            self.counts.lost_samples += number - self._next
        if self._overflow is not None:
            self.counts.overflow_samples += (overflow - self._overflow) % _WRAP
        self._overflow = overflow
        self._next, self._samples_received = number, True
        return number

    def _count_late(self, skipped: int, unheard: int) -> None:
        """Count predictions that the device skipped, and samples that its model did not process.

        The arguments are the totals of both since the device started.
        """
        if self._late is not None:
            self.counts.late_answers += (skipped - self._late[0]) % _WRAP
            self.counts.unheard_samples += (unheard - self._late[1]) % _WRAP
        self._late = skipped, unheard

    def _unwrapped(self, sample: int) -> int:
        if self._next is None:
            return sample
        ahead = (sample - self._next) % _WRAP
        return self._next + (ahead if ahead < _WRAP // 2 else ahead - _WRAP)

    def _flush(self, assembled: Assembled) -> None:
        if not self._run:
            return
        data = np.frombuffer(bytearray().join(self._run), dtype="<i2")
        data = data.reshape(-1, self._width)
        assembled.blocks.append(Block(data, self._run_first, self.epoch))
        self._run = []
