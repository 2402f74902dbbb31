"""A recording as a device that is plugged in: a port that any host can open."""

from __future__ import annotations

import math
import secrets
import select
import time
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import groupby
from pathlib import Path

from firstcontact.core import Block, InputError
from firstcontact.device._decoder import Decoder
from firstcontact.device._protocol import FRAME_SAMPLES, FrameType
from firstcontact.device._pseudo_terminal import PseudoTerminal
from firstcontact.device._responder import Responder
from firstcontact.device._source import Descriptor
from firstcontact.recording import Marker, Recording, read_recording

#: Samples that wait for a host that does not read, s of the host's time.
RING = 0.5
#: Longest time between two looks at whether to end, s.
TICK = 0.05
#: Frames are made ahead up to about this many bytes.
WIRE_BYTES = 4096
#: Most samples that are taken from the tape at once.
PIECE = 100
#: How long the last answer is left for the host to take, s.
LINGER = 1.0


class ReplayDevice:
    """Sends a recording to whoever asks, and then from its beginning again.

    The recording runs while a host has samples sent to it, and pauses otherwise. Each of
    its epochs is a life of the device: where one ends the device is silent, and begins
    the next when it is asked who it is. Gaps and markers come where they were recorded,
    and a gap takes no time. Marks of pinches and the calibration have no place in the
    protocol and stay behind.

    Parameters
    ----------
    path
        The recording; its samples must be int16, as the protocol has them.
    terminal
        Where the host is.
    speed
        Times real time; infinite to send as fast as the host takes it.

    Raises
    ------
    InputError
        The file is no recording, holds no samples or others than int16, or the speed
        is not positive.
    """

    def __init__(self, path: Path, terminal: PseudoTerminal, speed: float = 1.0) -> None:
        if not speed > 0:
            raise InputError(f"--speed is {speed:g}: give a positive number, or inf")
        recording = read_recording(path)
        header = recording.header
        if header.dtype != "int16":
            raise InputError(
                f"{path} cannot go over a wire: its samples are {header.dtype} and a device sends "
                "int16; give the recording itself to --device"
            )
        if not recording.samples:
            raise InputError(f"{path} holds no samples: there is nothing to replay")
        self.descriptor = Descriptor(
            replace(header.layout, groups=()),
            header.firmware,
            header.sensor,
            header.hand,
            header.source,
        )
        self._lives = list(_lives(recording))
        # A gap takes no time, so samples behind many of them come at a higher rate.
        paced = speed == 1.0 and all(len(blocks) == 1 for blocks, _ in self._lives)
        self.descriptor = replace(self.descriptor, paced=paced)
        #: Whether it was recorded with a calibration, which stays behind.
        self.calibrated = header.calibration is not None
        self._rate = header.layout.rate * speed
        self._boot = secrets.randbits(31)
        self._terminal = terminal
        self._ears = Decoder()
        self._begin(0)

    def run(self, stopped: Callable[[], bool] = lambda: False, once: bool = False) -> None:
        """Be the device.

        Parameters
        ----------
        stopped
            Asked several times a second whether to end.
        once
            End, too, when a host that had all of it has said something more: to stop, or
            who is there, as it does when it hears nothing.
        """
        until = math.inf
        while not stopped() and time.monotonic() < until:
            self._play()
            self._send()
            heard = self._wait()
            if heard and self._hear(heard, once) and once:
                self._send()
                until = time.monotonic() + LINGER

    def _begin(self, life: int) -> None:
        """Be switched on, at the beginning of an epoch."""
        self._life = life
        self._boot += 1
        blocks, markers = self._lives[life]
        self._tape = deque(blocks)
        self._markers = deque(markers)
        self._at = 0  # in the first block of the tape
        self._due = 0.0
        self._looked: float | None = None  # at the clock, while samples are sent
        self._drained = True
        self._wire = b""
        room = math.ceil(RING * self._rate) if math.isfinite(self._rate) else 0
        self._responder = Responder(self.descriptor, self._boot, max(room, 2 * PIECE))

    def _play(self) -> None:
        """Take from the tape what is due by now."""
        if not self._responder.streaming:
            self._looked = None
            return
        now = time.monotonic()
        if math.isinf(self._rate):
            self._due = float(PIECE if self._drained and not self._wire else 0)
        elif self._looked is not None:
            self._due += (now - self._looked) * self._rate
        self._looked = now
        while self._tape and self._due >= 1:
            block = self._tape[0]
            n = min(int(self._due), len(block.data) - self._at, PIECE)
            self._responder.next_sample = block.first_sample + self._at
            self._responder.sample(block.data[self._at : self._at + n])
            self._due -= n
            self._at += n
            if self._at == len(block.data):
                self._tape.popleft()
                self._at = 0
            while self._markers and (
                not self._tape or self._markers[0].sample < self._responder.next_sample
            ):
                marker = self._markers.popleft()
                self._responder.marker(marker.sample, marker.text)
            # What is late because this process was is no reason to drop anything.
            self._send()
        self._responder.finished = not self._tape

    def _send(self) -> None:
        """Send all that waits, or as much as the line takes."""
        while True:
            while len(self._wire) < WIRE_BYTES:
                frame = self._responder.frame()
                self._drained = not frame
                if not frame:
                    break
                self._wire += frame
            sent = self._terminal.write(self._wire) if self._wire else 0
            self._wire = self._wire[sent:]
            if not sent:
                return

    def _wait(self) -> bytes:
        """What the host says, waiting for it until something else is to be done."""
        wait = TICK
        if self._responder.streaming and self._tape:
            rest = (FRAME_SAMPLES - self._due) / self._rate
            wait = min(max(rest, 0.0), TICK) if not self._wire else TICK
        listening = [self._terminal] if self._responder.listens else []
        full = [self._terminal] if self._wire else []
        readable, _, _ = select.select(listening, full, [], wait)
        return self._terminal.read() if readable else b""

    def _hear(self, data: bytes, once: bool) -> bool:
        """Answer the host; whether it has had everything."""
        sent = not self._tape and self._drained and not self._wire
        last = self._life + 1 == len(self._lives)
        asked = any(frame.type == FrameType.HELLO for frame in self._ears.feed(data))
        if asked and sent and not (once and last):
            self._begin((self._life + 1) % len(self._lives))
        self._responder.hear(data)
        return sent and last


def _lives(recording: Recording) -> Iterator[tuple[list[Block], list[Marker]]]:
    """Blocks and markers of each epoch that has samples; markers of others are left out."""
    for epoch, blocks in groupby(recording.stretches, lambda block: block.epoch):
        markers = [m for m in recording.markers if m.epoch == epoch]
        yield list(blocks), sorted(markers, key=lambda m: m.sample)
