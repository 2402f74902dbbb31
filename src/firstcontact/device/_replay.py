"""Source that replays a recording at any speed."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Self

from firstcontact.core import Block, Calibration, ClosingSpeed, InputError
from firstcontact.device._opening import SourceOptions
from firstcontact.device._source import Arrival, Descriptor, Health, check_readable
from firstcontact.recording import Marker, PinchMark, Recording, read_recording

#: Number of samples in a block at a finite speed, like the blocks of a device ...
BLOCK = 5
#: ... and at infinite speed, 0.1 s at 4936 Hz.
LONG_BLOCK = 494


class ReplaySource:
    """Source that replays a recording as if its device were connected.

    Epochs, gaps, markers and pinch marks come at their recorded samples. A gap takes no time.

    Parameters
    ----------
    path
        Path of the recording.
    speed
        Multiple of real time; infinite to read as fast as possible.
    block
        Number of samples in a block, 1 or more.

    Raises
    ------
    InputError
        The file is no recording, has no samples, or the speed is not positive.

    Notes
    -----
    The recording begins to play at the first read. At a finite speed, the arrival time of a block
    is the time at which it is due, however late it is read. At infinite speed, it is the time of
    the read.
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
        self._is_open = self._is_drained = False
        self._began: float | None = None  # time of the first read
        self._paced = math.isfinite(speed)
        self._given = 0
        self._lost = 0
        self._end: Block | None = None
        #: Condition and random seed of the simulated hand; None if a real hand was recorded.
        self.twin_hand: tuple[str, int] | None = None

    @property
    def speed(self) -> float:
        """Speed as a multiple of real time; infinite to read as fast as possible."""
        return self._speed

    @property
    def name(self) -> str:
        """Path of the file."""
        return str(self._recording.path)

    @property
    def descriptor(self) -> Descriptor:
        """Metadata from the recording's header."""
        h = self._recording.header
        # Groups are left out: a device sends only the samples in which contacts are detected.
        layout = replace(h.layout, groups=())
        return Descriptor(layout, h.firmware, h.sensor, h.hand, h.source, h.dtype)

    @property
    def calibration(self) -> Calibration | None:
        """Calibration from the recording's header."""
        return self._recording.header.calibration

    @property
    def health(self) -> Health:
        """Counts of samples delivered, and of samples missing in the recording."""
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
        """Return True if all samples were delivered."""
        return self._ended

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        """Return all blocks due by now. If there is none, wait for the next, at most ``timeout`` s.

        ``least`` has no effect.
        """
        if not self._is_open:
            raise InputError(f"{self.name} is not open: use the source in a with block")
        check_readable(self, timeout, is_drained=self._is_drained)
        if self._ended:
            self._is_drained = self._closed.is_set()
            return []
        if self._began is None:
            self._began = time.monotonic()
        if not self._paced:
            return self._take(time.monotonic(), 1)
        wait = self._due() - time.monotonic()
        if wait > 0 and self._closed.wait(min(wait, timeout)):
            return []
        return self._take(time.monotonic())

    def closing_speed(self, sample: int, epoch: int) -> ClosingSpeed | None:
        """Return the recorded closing speed of the pinch that holds ``sample``."""
        for mark in self._recording.pinches:
            if mark.epoch == epoch and mark.first_sample <= sample < mark.end:
                return mark.closing_speed
        return None

    def mark(self, text: str) -> None:
        """Refuse the marker: a recording does not change.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(f"{self.name} is a recording: it takes no markers")

    def order(self, text: str) -> None:
        """Refuse the order: a recording has no hand.

        Raises
        ------
        InputError
            Always.
        """
        raise InputError(f"{self.name} is a recording: it takes no orders")

    def close(self) -> None:
        """End the replay."""
        self._closed.set()
        self._ended = True

    def __enter__(self) -> Self:
        self._is_open = True
        self._advance()
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _due(self) -> float:
        """Return the time at which the next block is due, s of the monotonic clock."""
        if self._next is None or self._began is None:
            return math.inf
        samples = self._given + len(self._next[0].data)
        return self._began + samples / (self._speed * self._recording.header.layout.rate)

    def _take(self, now: float, most: int | None = None) -> list[Arrival]:
        """Return the blocks due by now, at most ``most``."""
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
    """Yield blocks with their markers and pinch marks."""
    markers = deque(sorted(recording.markers, key=lambda m: (m.epoch, m.sample)))
    pinches = deque(sorted(recording.pinches, key=lambda m: (m.epoch, m.end)))
    for stretch in recording.stretches:
        last = stretch is recording.stretches[-1]
        for start in range(0, len(stretch.data), length):
            data = stretch.data[start : start + length]
            block = Block(data, stretch.first_sample + start, stretch.epoch)
            until = (block.epoch, block.end)
            # Markers of samples after the last one come with the last block.
            is_last = last and start + length >= len(stretch.data)
            block_markers, block_pinches = [], []
            while markers and (is_last or (markers[0].epoch, markers[0].sample) < until):
                block_markers.append(markers.popleft())
            while pinches and (is_last or (pinches[0].epoch, pinches[0].end) <= until):
                block_pinches.append(pinches.popleft())
            yield block, tuple(block_markers), tuple(block_pinches)


def from_path(path: str, options: SourceOptions) -> ReplaySource:
    """Return the replay of a recording at the requested speed."""
    source = ReplaySource(Path(path), options.speed)
    if source.descriptor.source == "twin":
        source.twin_hand = options.condition, options.seed
    return source
