"""Replay of a recording: as a source at any speed, and as a serial device for any host."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple, Self

from firstcontact.core import ArgumentError, Block, ClosingSpeed, DeviceError, FileError
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.opening import SourceOptions, check_speed
from firstcontact.device.ports import PseudoTerminal
from firstcontact.device.protocol import FRAME_SAMPLES, Decoder, FrameType
from firstcontact.device.responder import RING, TerminalDevice
from firstcontact.device.source import Arrival, Health, Source
from firstcontact.recording import Marker, PinchMark, Recording, read_recording

#: Number of samples in a block at a finite speed, like the blocks of a device ...
BLOCK = 5
#: ... and at infinite speed, 0.1 s at 4936 Hz.
LONG_BLOCK = 494
#: Number of blocks that are read from the file at a time.
AHEAD = 100
#: Longest time between two checks for a stop, s.
TICK = 0.05
#: Number of samples that are due at a time at infinite speed.
PIECE = 100
#: Time for the host to read the last answer, s.
LINGER = 1.0


class _Piece(NamedTuple):
    block: Block
    markers: tuple[Marker, ...]
    pinches: tuple[PinchMark, ...]


def _read(path: Path, speed: float) -> tuple[Recording, Descriptor]:
    check_speed(speed)
    recording = read_recording(path)
    if not recording.samples:
        raise FileError(f"{path} holds no samples: choose another recording")
    h = recording.header
    # Groups are left out: a device sends only the samples in which contacts are detected.
    layout = replace(h.layout, groups=())
    return recording, Descriptor(layout, h.firmware, h.sensor, h.hand, h.source, h.dtype)


class ReplaySource(Source):
    """Source that replays a recording, from the first read on, as if its device were connected.

    ``speed`` is a multiple of real time, infinite for as fast as possible. Gaps take no time. At a
    finite speed, a block's arrival time is the time at which it is due, however late it is read.
    ``block`` is the number of samples in a block.
    """

    is_replay = True

    def __init__(self, path: Path, speed: float = 1.0, block: int | None = None) -> None:
        self._recording, self._descriptor = _read(path, speed)
        if block is not None and block < 1:
            raise ArgumentError(f"the block size is {block} samples: give 1 or more")
        self.speed = speed
        self.calibration = self._recording.header.calibration
        self._block = block or (LONG_BLOCK if math.isinf(speed) else BLOCK)
        self._rest = _split_recording(self._recording, self._block)
        self._next: _Piece | None = None
        self._ended = False
        self._closed = threading.Event()
        self._is_open = self._is_drained = False
        self._began: float | None = None  # time of the first read
        self._paced = math.isfinite(speed)
        self._given = 0
        self._lost = 0
        self._end: Block | None = None

    @property
    def name(self) -> str:
        return str(self._recording.path)

    @property
    def recording(self) -> Recording:
        return self._recording

    @property
    def descriptor(self) -> Descriptor:
        return self._descriptor

    @property
    def health(self) -> Health:
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
        return self._ended

    def read(self, timeout: float, least: int = 1) -> list[Arrival]:
        if not self._is_open:
            raise self._not_open()
        self._check_readable(timeout, is_drained=self._is_drained)
        if self._ended:
            self._is_drained = self._closed.is_set()
            return []
        if self._began is None:
            self._began = time.monotonic()
        if not self._paced:
            return self._due_arrivals(time.monotonic(), 1)
        wait = self._due() - time.monotonic()
        if wait > 0 and self._closed.wait(min(wait, timeout)):
            return []
        return self._due_arrivals(time.monotonic())

    def closing_speed(self, sample: int, epoch: int) -> ClosingSpeed | None:
        for mark in self._recording.pinches:
            if mark.epoch == epoch and mark.first_sample <= sample < mark.end:
                return mark.closing_speed
        return None

    def mark(self, text: str) -> None:
        raise DeviceError(
            f"{self.name} is a recording, to which no markers can be added: use a live source"
        )

    def order(self, text: str) -> None:
        raise DeviceError(
            f"{self.name} is a recording, which follows no orders: use the device twin"
        )

    def close(self) -> None:
        self._closed.set()
        self._ended = True

    def __enter__(self) -> Self:
        self._is_open = True
        self._advance()
        return self

    def _due(self) -> float:
        if self._next is None or self._began is None:
            return math.inf
        samples = self._given + len(self._next[0].data)
        return self._began + samples / (self.speed * self._recording.header.layout.rate)

    def _due_arrivals(self, now: float, most: int | None = None) -> list[Arrival]:
        """Return the blocks that are due at ``now``, s of ``time.monotonic()``.

        Return at most ``most`` blocks. None means that there is no limit.
        """
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


def _split_recording(
    recording: Recording, length: int, epoch: int | None = None
) -> Iterator[_Piece]:
    """Yield a recording as blocks of ``length`` samples, with the markers and pinches in them.

    If ``epoch`` is given, yield only the blocks of this epoch.
    """
    stretches = [s for s in recording.stretches if epoch in (None, s.epoch)]
    wanted = [m for m in recording.markers if epoch in (None, m.epoch)]
    markers = deque(sorted(wanted, key=lambda m: (m.epoch, m.sample)))
    pinches = deque(sorted(recording.pinches, key=lambda m: (m.epoch, m.first_sample)))
    for stretch in stretches:
        part = stretch.part(stretch.first_sample, stretch.first_sample)
        for first in range(stretch.first_sample, stretch.end, length):
            end = min(first + length, stretch.end)
            if end > part.end:
                part = stretch.part(first, min(first + AHEAD * length, stretch.end))
            block = Block(part.part(first, end).data, first, stretch.epoch)
            # Markers of samples after the last one come with the last block.
            is_last = stretch is stretches[-1] and end == stretch.end
            until = (math.inf, 0) if is_last else (block.epoch, block.end)
            block_markers, block_pinches = [], []
            while markers and (markers[0].epoch, markers[0].sample) < until:
                block_markers.append(markers.popleft())
            while pinches and (pinches[0].epoch, pinches[0].first_sample) < until:
                block_pinches.append(pinches.popleft())
            yield _Piece(block, tuple(block_markers), tuple(block_pinches))


def from_path(path: str, options: SourceOptions) -> ReplaySource:
    source = ReplaySource(Path(path), options.speed)
    if source.descriptor.source == "twin":
        source.twin_hand = options.condition, options.seed
    return source


class ReplayDevice(TerminalDevice):
    """Simulated serial device that sends a recording of int16 samples to its host, in a loop.

    At the end of an epoch the device falls silent, and the host's next hello frame begins the next
    epoch. Pinch marks and the calibration are not sent: the protocol has no frames for them.
    """

    def __init__(self, path: Path, terminal: PseudoTerminal, speed: float = 1.0) -> None:
        recording, descriptor = _read(path, speed)
        header = recording.header
        if header.dtype != "int16":
            raise FileError(
                f"{path} cannot be sent by a serial device: its samples are {header.dtype}, not "
                "int16: give the recording itself to --device"
            )
        self._recording = recording
        self._epochs = sorted({stretch.epoch for stretch in recording.stretches})
        # A gap takes no time, so a recording with many gaps sends samples at a higher rate.
        paced = speed == 1.0 and len(self._epochs) == len(recording.stretches)
        self.descriptor = replace(descriptor, paced=paced)
        self._rate = header.layout.rate * speed
        super().__init__(terminal)
        self._decoder = Decoder()
        self._begin(0)

    def run(self, stopped: Callable[[], bool] = lambda: False, once: bool = False) -> None:
        deadline = math.inf
        while not stopped() and time.monotonic() < deadline:
            self._play()
            self._send()
            data = self._listen()
            if data and self._hear(data, once) and once:
                self._send()
                deadline = time.monotonic() + LINGER

    def _begin(self, epoch_index: int) -> None:
        self._epoch_index = epoch_index
        self._tape = _split_recording(self._recording, FRAME_SAMPLES, self._epochs[epoch_index])
        self._next = next(self._tape, None)
        self._due = 0.0
        self._last_update: float | None = None  # time of the last update, while samples are sent
        room = math.ceil(RING * self._rate) if math.isfinite(self._rate) else 0
        self._restart(self.descriptor, max(room, 2 * PIECE))

    def _play(self) -> None:
        if not self._responder.streaming:
            self._last_update = None
            return
        now = time.monotonic()
        if math.isinf(self._rate):
            self._due = float(0 if self._wire else PIECE)
        elif self._last_update is not None:
            self._due += (now - self._last_update) * self._rate
        self._last_update = now
        while self._next is not None and self._due >= len(self._next.block.data):
            block = self._next.block
            self._responder.next_sample = block.first_sample
            self._responder.sample(block.data)
            for marker in self._next.markers:
                self._responder.marker(marker.sample, marker.text)
            self._due -= len(block.data)
            self._next = next(self._tape, None)
            # Send now: a delay of this process must not make samples overflow.
            self._send()
        self._responder.finished = self._next is None

    def _listen(self) -> bytes:
        """Wait for bytes from the host, and return them; b"" if samples are due before."""
        wait = TICK
        if self._responder.streaming and self._next is not None:
            until_due = (FRAME_SAMPLES - self._due) / self._rate
            wait = min(max(until_due, 0.0), TICK) if not self._wire else TICK
        return self._terminal.read() if self._wait(wait) else b""

    def _hear(self, data: bytes, once: bool) -> bool:
        """Process bytes from the host. Return True if the whole recording has been sent.

        ``once`` is True to send the recording only once, False to send it again and again.
        """
        sent = self._next is None and not self._wire
        is_last_epoch = self._epoch_index + 1 == len(self._epochs)
        has_hello = any(frame.type == FrameType.HELLO for frame in self._decoder.feed(data))
        if has_hello and sent and not (once and is_last_epoch):
            self._begin((self._epoch_index + 1) % len(self._epochs))
        self._responder.hear(data)
        return sent and is_last_epoch
