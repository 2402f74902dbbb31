"""Samples out of frames: numbered in 64 bits, epochs told apart, every loss counted."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from firstcontact.core import Block
from firstcontact.device.protocol import (
    Frame,
    FrameError,
    FrameType,
    read_marker,
    read_samples,
    read_stopped,
)
from firstcontact.recording import Marker

_WRAP = 1 << 32


@dataclass(slots=True)
class Counts:
    """What was received and what was not; see :class:`firstcontact.device.source.Health`."""

    samples: int = 0
    lost_samples: int = 0
    overflow_samples: int = 0
    lost_frames: int = 0
    doubled_frames: int = 0
    malformed_frames: int = 0


@dataclass(slots=True, eq=False)
class Assembled:
    """What a number of frames gave: blocks and markers in order, and whether the device stopped."""

    blocks: list[Block] = field(default_factory=list)
    markers: list[Marker] = field(default_factory=list)
    stopped: bool = False


class Assembler:
    """Joins the samples of frames into blocks.

    A frame that comes late or twice is left out: it was counted as lost when the
    next came first. After :meth:`begin` with another boot number the device's
    counts start anew; with the same one they go on, and what was missed between
    is counted.

    Parameters
    ----------
    channels
        Columns of a sample.
    """

    def __init__(self, channels: int) -> None:
        self.counts = Counts()
        #: Of the samples that come next.
        self.epoch = -1
        self._channels = channels
        self._boot: int | None = None
        self._counter: int | None = None
        self._next: int | None = None
        self._overflow: int | None = None

    def begin(self, boot: int, *, interrupted: bool = True) -> None:
        """A handshake was made: a new epoch, unless the same start goes on uninterrupted."""
        if boot != self._boot:
            self._counter = self._next = self._overflow = None
        if boot != self._boot or interrupted:
            self.epoch += 1
        self._boot = boot

    def take(self, frames: list[Frame]) -> Assembled:
        """The next frames in the order they came."""
        out = Assembled()
        pieces: list[Block] = []
        for frame in frames:
            if frame.type not in _READ or not self._in_turn(frame.counter):
                continue
            try:
                if frame.type == FrameType.SAMPLES:
                    self._samples(frame.payload, pieces)
                elif frame.type == FrameType.MARKER:
                    sample, text = read_marker(frame.payload)
                    out.markers.append(Marker(self._unwrapped(sample), text, self.epoch))
                elif frame.type == FrameType.STOPPED:
                    self._account(*read_stopped(frame.payload))
                    out.stopped = True
            except FrameError:
                self.counts.malformed_frames += 1
        out.blocks = _joined(pieces)
        return out

    def _in_turn(self, counter: int) -> bool:
        if self._counter is not None:
            ahead = (counter - self._counter) % _WRAP
            if ahead >= _WRAP // 2:
                self.counts.doubled_frames += 1
                return False
            self.counts.lost_frames += ahead
        self._counter = (counter + 1) % _WRAP
        return True

    def _samples(self, payload: bytes, pieces: list[Block]) -> None:
        frame = read_samples(payload, self._channels)
        first = self._account(frame.first_sample, frame.overflow)
        if first is None:
            self.counts.doubled_frames += 1
            return
        block = Block(frame.data, first, self.epoch)
        self._next = block.end
        self.counts.samples += len(frame.data)
        pieces.append(block)

    def _account(self, sample: int, overflow: int) -> int | None:
        """Count what is missing before a sample; its 64-bit number, None if it was there before."""
        number = self._unwrapped(sample)
        if self._overflow is not None:
            self.counts.overflow_samples += (overflow - self._overflow) % _WRAP
        self._overflow = overflow
        if self._next is not None:
            if number < self._next:
                return None
            self.counts.lost_samples += number - self._next
        self._next = number
        return number

    def _unwrapped(self, sample: int) -> int:
        if self._next is None:
            return sample
        ahead = (sample - self._next) % _WRAP
        return self._next + (ahead if ahead < _WRAP // 2 else ahead - _WRAP)


_READ = frozenset({FrameType.SAMPLES, FrameType.MARKER, FrameType.STOPPED})


def _joined(pieces: list[Block]) -> list[Block]:
    """Blocks that follow one another, as one."""
    runs: list[list[Block]] = []
    for piece in pieces:
        if runs and runs[-1][-1].end == piece.first_sample and runs[-1][-1].epoch == piece.epoch:
            runs[-1].append(piece)
        else:
            runs.append([piece])
    return [
        r[0]
        if len(r) == 1
        else Block(np.concatenate([b.data for b in r]), r[0].first_sample, r[0].epoch)
        for r in runs
    ]
