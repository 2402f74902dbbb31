"""A recording that comes again as it came, at any speed."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Self

from firstcontact.core import Block, Calibration, InputError
from firstcontact.device._opening import SourceOptions
from firstcontact.device._source import Arrival, Descriptor, Health
from firstcontact.recording import Marker, PinchMark, Recording, read_recording

#: Samples of a block: as a device sends them, in real time ...
BLOCK = 5
#: ... and without a pace, 0.1 s at 4936 Hz.
LONG_BLOCK = 494


class ReplaySource:
    """Plays a recording as if its device were there.

    Epochs, gaps, markers and marks of pinches come where they were recorded. A gap
    takes no time.

    Parameters
    ----------
    path
        The recording.
    speed
        Times real time; infinite to give all as fast as it is read.
    block
        Samples of a block, 1 or more.

    Raises
    ------
    InputError
        The file is no recording, holds no samples, or the speed is not positive.

    Notes
    -----
    At a pace, a block's time of arrival is when it is due, however late it is read;
    without one, it is when it is read.
    """

    def __init__(self, path: Path, speed: float = 1.0, block: int | None = None) -> None:
        if not speed > 0:
            raise InputError(f"--speed is {speed:g}: give a positive number, or inf")
        self._recording = read_recording(path)
        if block is not None and block < 1:
            raise InputError(f"a block of {block} samples cannot be replayed: use 1 or more")
        if not self._recording.samples:
            raise InputError(f"{path} holds no samples: there is nothing to replay")
        self._speed = speed
        self._block = block or (LONG_BLOCK if math.isinf(speed) else BLOCK)
        self._rest = _pieces(self._recording, self._block)
        self._next: tuple[Block, tuple[Marker, ...], tuple[PinchMark, ...]] | None = None
        self._ended = False
        self._closed = threading.Event()
        self._began = 0.0
        self._paced = math.isfinite(speed)
        self._given = 0
        self._lost = 0
        self._end: Block | None = None

    @property
    def speed(self) -> float:
        """Multiple of real time; inf without a pace."""
        return self._speed

    @property
    def name(self) -> str:
        """The file."""
        return str(self._recording.path)

    @property
    def descriptor(self) -> Descriptor:
        """What the recording says about what it was made with."""
        h = self._recording.header
        # What is replayed is what a device sends: the samples that contacts are looked for in.
        layout = replace(h.layout, groups=())
        return Descriptor(layout, h.firmware, h.sensor, h.hand, h.source, h.dtype)

    @property
    def calibration(self) -> Calibration | None:
        """What was measured before the recording was made."""
        return self._recording.header.calibration

    @property
    def health(self) -> Health:
        """Samples given so far, and those missing in the recording."""
        epoch = self._end.epoch if self._end else 0
        return Health(
            connected=not self._ended,
            epoch=epoch,
            samples=self._given,
            lost_samples=self._lost,
            ended=self._ended,
        )

    @property
    def ended(self) -> bool:
        """Whether all was given."""
        return self._ended

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """All that is due by now, waiting up to ``timeout`` s for something to be.

        Its blocks come as they come: ``least`` changes nothing.
        """
        if not self._began:
            raise InputError(f"{self.name} is not open: enter the source first")
        if self._ended:
            return []
        if not self._paced:
            return self._take(time.monotonic(), 1)
        wait = self._due() - time.monotonic()
        if wait > 0 and self._closed.wait(min(wait, timeout)):
            return []
        return self._take(time.monotonic())

    def mark(self, text: str) -> None:
        """Refuse: what is recorded stays as it is.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(f"{self.name} is a recording: no marker can be set in what has happened")

    def order(self, text: str) -> None:
        """Refuse: what has happened takes no order.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(f"{self.name} is a recording: nothing can be ordered in what has happened")

    def close(self) -> None:
        """End the replay."""
        self._closed.set()
        self._ended = True

    def __enter__(self) -> Self:
        self._began = time.monotonic()
        self._advance()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _due(self) -> float:
        """When the last sample of the next block comes, s of the monotonic clock."""
        if self._next is None:
            return math.inf
        samples = self._given + len(self._next[0].data)
        return self._began + samples / (self._speed * self._recording.header.layout.rate)

    def _take(self, now: float, most: int | None = None) -> list[Arrival]:
        """What is due by now."""
        arrivals: list[Arrival] = []
        while self._next is not None and len(arrivals) != most:
            due = self._due() if self._paced else now
            if due > now:
                break
            block, markers, pinches = self._next
            if self._end is not None and self._end.epoch == block.epoch:
                self._lost += block.first_sample - self._end.end
            self._given += len(block.data)
            self._end = block
            arrivals.append(Arrival(block, due, markers, pinches))
            self._advance()
        return arrivals

    def _advance(self) -> None:
        self._next = next(self._rest, None)
        if self._next is None:
            self._ended = True


def _pieces(
    recording: Recording, length: int
) -> Iterator[tuple[Block, tuple[Marker, ...], tuple[PinchMark, ...]]]:
    """Blocks with the markers and pinch marks that belong to them."""
    markers = deque(sorted(recording.markers, key=lambda m: (m.epoch, m.sample)))
    pinches = deque(sorted(recording.pinches, key=lambda m: (m.epoch, m.end)))
    for stretch in recording.stretches:
        last = stretch is recording.stretches[-1]
        for start in range(0, len(stretch.data), length):
            data = stretch.data[start : start + length]
            block = Block(data, stretch.first_sample + start, stretch.epoch)
            until = (block.epoch, block.end)
            # What is pinned to samples after the last one comes with the last one.
            everything = last and start + length >= len(stretch.data)
            told, done = [], []
            while markers and (everything or (markers[0].epoch, markers[0].sample) < until):
                told.append(markers.popleft())
            while pinches and (everything or (pinches[0].epoch, pinches[0].end) <= until):
                done.append(pinches.popleft())
            yield block, tuple(told), tuple(done)


def from_path(path: str, options: SourceOptions) -> ReplaySource:
    """The recording at a path, at the speed that was asked for."""
    return ReplaySource(Path(path), options.speed)
