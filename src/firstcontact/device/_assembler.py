"""Samples out of frames: numbered in 64 bits, epochs told apart, every loss counted."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from firstcontact.core import Block, InputError
from firstcontact.device._device_predictions import (
    DevicePrediction,
    check_place,
    read_contact,
    read_estimate,
)
from firstcontact.device._handshake import read_greeting, refusal
from firstcontact.device._protocol import (
    Frame,
    FrameError,
    FrameType,
    read_late,
    read_marker,
    read_stopped,
    samples_head,
)
from firstcontact.device._source import Descriptor
from firstcontact.recording import Marker

_WRAP = 1 << 32
#: A device that answers by itself tells of samples that are at most so far from those that come, s,
#: also where its host did not read for a while.
FARTHEST = 60.0


@dataclass(slots=True)
class Counts:
    """What was received and what was not; see :class:`firstcontact.device._source.Health`.

    ``malformed_frames`` came whole and hold what they should not.
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
    """What a number of frames gave: blocks, markers and the device's own answers, each in order.

    ``greeted`` and ``stopped`` tell whether a descriptor, or the end, was among them.
    """

    blocks: list[Block] = field(default_factory=list)
    markers: list[Marker] = field(default_factory=list)
    predictions: list[DevicePrediction] = field(default_factory=list)
    greeted: bool = False
    stopped: bool = False


class Assembler:
    """Joins the samples of frames into blocks.

    What comes before the first descriptor belongs to another host and is left out. A
    descriptor with another boot number, or one that was asked for and whose frame
    counter has gone back, tells of a restarted device: its counts start anew in
    a new epoch. After :meth:`interrupted` the same start goes on in a new epoch, and
    what was missed in between is counted. A frame that comes late or twice is left
    out: it was counted as lost when the next came first.

    Attributes
    ----------
    counts
        Since the beginning.
    epoch
        Of the samples that come next; -1 before the first descriptor.
    descriptor
        What the device said about itself; None before.
    """

    def __init__(self) -> None:
        self.counts = Counts()
        self.epoch = -1
        self.descriptor: Descriptor | None = None
        self._width = 0  # of its samples, looked up for every frame
        self._listening = False  # since a descriptor came on this connection
        self._asked = False
        self._goes_on = False  # since samples came on this connection
        self._fits = False  # some samples frame of this start had the layout's columns
        self._boot = 0
        self._counter: int | None = None
        self._next: int | None = None
        self._overflow: int | None = None
        self._late: tuple[int, int] | None = None  # what its own answers missed since its start
        self._run: list[bytes] = []  # samples that follow one another ...
        self._run_first = 0  # ... and the number of the first

    @property
    def next_sample(self) -> int:
        """Number of the sample that comes next; 0 before the first."""
        return self._next or 0

    def asked(self) -> None:
        """The device was asked for its descriptor."""
        self._asked = True

    def interrupted(self) -> None:
        """The connection was lost: nothing is taken before the next descriptor."""
        self._listening = False

    def take(self, frames: list[Frame]) -> Assembled:
        """The next frames, in the order they came.

        Raises
        ------
        InputError
            The device speaks another version, refuses, has another layout than
            before, or sends other columns than its layout has.
        """
        out = Assembled()
        for frame in frames:
            try:
                if frame.type == FrameType.DESCRIPTOR:
                    self._flush(out)
                    out.greeted |= self._greeting(frame)
                elif frame.type == FrameType.REFUSED:
                    raise refusal(frame.payload)
                elif self._listening and self._in_turn(frame.counter):
                    self._content(frame, out)
            except FrameError as error:
                self.counts.malformed_frames += 1
                if frame.type == FrameType.SAMPLES and not self._fits:
                    raise InputError(
                        f"the device does not send what its descriptor says ({error}): flash the "
                        "firmware that belongs to this version of firstcontact"
                    ) from error
        self._flush(out)
        return out

    def _greeting(self, frame: Frame) -> bool:
        """Whether a descriptor is news."""
        greeting = read_greeting(frame.payload)
        if self.descriptor is None:
            self.descriptor = greeting.descriptor
            self._width = greeting.descriptor.layout.width
        elif greeting.descriptor.layout != self.descriptor.layout:
            raise InputError(
                "another device is on this port now, with other channels or another rate: "
                "start again to use it"
            )
        back = self._counter is not None and self._ahead(frame.counter) < 0
        restarted = self.epoch < 0 or greeting.boot != self._boot or (back and self._asked)
        self._asked = False
        if restarted:
            self._counter = self._next = self._overflow = self._late = None
            self._fits = False
            self._boot = greeting.boot
        if not self._in_turn(frame.counter):
            return False
        if restarted or not self._listening:
            self.epoch += 1
        self._listening, self._goes_on = True, False
        return True

    def _content(self, frame: Frame, out: Assembled) -> None:
        if frame.type == FrameType.SAMPLES:
            self._samples(frame.payload, out)
        elif frame.type == FrameType.MARKER:
            sample, text = read_marker(frame.payload)
            out.markers.append(Marker(self._unwrapped(sample), text, self.epoch))
        elif frame.type == FrameType.CONTACT:
            contact = read_contact(frame.payload, self.epoch)
            sample, known = self._unwrapped(contact.sample), self._unwrapped(contact.decided)
            self._tell(replace(contact, sample=sample, decided=known), out)
        elif frame.type == FrameType.ESTIMATE:
            estimate = read_estimate(frame.payload, self.epoch)
            sample, known = self._unwrapped(estimate.contact), self._unwrapped(estimate.decided)
            self._tell(replace(estimate, contact=sample, decided=known), out)
        elif frame.type == FrameType.LATE:
            self._missed(*read_late(frame.payload))
        elif frame.type == FrameType.STOPPED:
            self._account(*read_stopped(frame.payload))
            out.stopped = True

    def _tell(self, answer: DevicePrediction, out: Assembled) -> None:
        """Add a contact or an estimate of the device, if its samples can exist."""
        assert self.descriptor is not None
        newest = self._next if self._next is not None and self._goes_on else answer.decided
        check_place(answer, newest, round(FARTHEST * self.descriptor.layout.rate))
        out.predictions.append(answer)

    def _ahead(self, counter: int) -> int:
        """How far a frame is ahead of the one that should come; negative if it is late."""
        assert self._counter is not None
        ahead = (counter - self._counter) % _WRAP
        return ahead if ahead < _WRAP // 2 else ahead - _WRAP

    def _in_turn(self, counter: int) -> bool:
        if self._counter is not None:
            ahead = self._ahead(counter)
            if ahead < 0:
                self.counts.doubled_frames += 1
                return False
            self.counts.lost_frames += ahead
        self._counter = (counter + 1) % _WRAP
        return True

    def _samples(self, payload: bytes, out: Assembled) -> None:
        sample, overflow, n, data = samples_head(payload, self._width)
        self._fits = True
        before = self._next
        first = self._account(sample, overflow)
        if first is None:
            self.counts.doubled_frames += 1
            return
        if first != before:
            self._flush(out)
            self._run_first = first
        elif not self._run:
            self._run_first = first
        self._run.append(data)
        self._next = first + n
        self.counts.samples += n

    def _account(self, sample: int, overflow: int) -> int | None:
        """Count what is missing before a sample; its 64-bit number, None if it was there before."""
        number = self._unwrapped(sample)
        if self._next is not None:
            if number < self._next:
                return None
            self.counts.lost_samples += number - self._next
        if self._overflow is not None:
            self.counts.overflow_samples += (overflow - self._overflow) % _WRAP
        self._overflow = overflow
        self._next, self._goes_on = number, True
        return number

    def _missed(self, skipped: int, unheard: int) -> None:
        """Count what the device's own answers missed since it last said so."""
        if self._late is not None:
            self.counts.late_answers += (skipped - self._late[0]) % _WRAP
            self.counts.unheard_samples += (unheard - self._late[1]) % _WRAP
        self._late = skipped, unheard

    def _unwrapped(self, sample: int) -> int:
        if self._next is None:
            return sample
        ahead = (sample - self._next) % _WRAP
        return self._next + (ahead if ahead < _WRAP // 2 else ahead - _WRAP)

    def _flush(self, out: Assembled) -> None:
        """Make a block of the samples that follow one another."""
        if not self._run:
            return
        data = np.frombuffer(bytearray().join(self._run), dtype="<i2")
        data = data.reshape(-1, self._width)
        out.blocks.append(Block(data, self._run_first, self.epoch))
        self._run = []
