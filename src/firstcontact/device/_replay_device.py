"""Recording served as a serial device that any host can open."""

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

#: Length of the buffer for a host that does not read, s of the host's time.
RING = 0.5
#: Longest time between two checks for a stop, s.
TICK = 0.05
#: Approximate number of bytes of frames prepared in advance.
WIRE_BYTES = 4096
#: Largest number of samples taken from the recording at a time.
PIECE = 100
#: Time for the host to read the last answer, s.
LINGER = 1.0


class ReplayDevice:
    """Device that sends a recording to its host, again and again.

    The recording plays after the host has sent a start frame, and pauses after a stop frame. At the
    end of an epoch the device falls silent. The host's next hello frame begins the next epoch, as
    if the device had restarted.

    Gaps and markers come at their recorded samples, and a gap takes no time. Pinch marks and the
    calibration are not sent, because the protocol has no frames for them.

    Parameters
    ----------
    path
        Path of the recording. Its samples must be int16, as in the protocol.
    terminal
        Terminal with the host at its other end.
    speed
        Multiple of real time; infinite to send as fast as the host reads.

    Raises
    ------
    InputError
        The file is no recording, has no samples or a type other than int16, or the speed is not
        positive.
    """

    def __init__(self, path: Path, terminal: PseudoTerminal, speed: float = 1.0) -> None:
        if not speed > 0:
            raise InputError(f"--speed is {speed:g}: give a positive number, or inf")
        recording = read_recording(path)
        header = recording.header
        if header.dtype != "int16":
            raise InputError(
                f"{path} cannot be sent by a serial device: its samples are {header.dtype}, not "
                "int16: give the recording itself to --device"
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
        self._epochs = list(_epochs(recording))
        # A gap takes no time, so a recording with many gaps sends samples at a higher rate.
        paced = speed == 1.0 and all(len(blocks) == 1 for blocks, _ in self._epochs)
        self.descriptor = replace(self.descriptor, paced=paced)
        #: True if the recording has a calibration, which is not sent.
        self.calibrated = header.calibration is not None
        self._rate = header.layout.rate * speed
        self._boot = secrets.randbits(31)
        self._terminal = terminal
        self._decoder = Decoder()
        self._begin(0)

    def run(self, stopped: Callable[[], bool] = lambda: False, once: bool = False) -> None:
        """Run the device.

        Parameters
        ----------
        stopped
            Predicate that ends the run. It is called several times a second.
        once
            True to end the run once the whole recording was sent and the host has sent one more
            frame: a stop frame, or a hello frame because no samples come.
        """
        deadline = math.inf
        while not stopped() and time.monotonic() < deadline:
            self._play()
            self._send()
            data = self._wait()
            if data and self._hear(data, once) and once:
                self._send()
                deadline = time.monotonic() + LINGER

    def _begin(self, epoch_index: int) -> None:
        """Start the device at the beginning of an epoch."""
        self._epoch_index = epoch_index
        self._boot += 1
        blocks, markers = self._epochs[epoch_index]
        self._tape = deque(blocks)
        self._markers = deque(markers)
        self._position = 0  # position in the first block that is not sent yet
        self._due = 0.0
        self._last_look: float | None = None  # time of the last update, while samples are sent
        self._drained = True
        self._wire = b""
        room = math.ceil(RING * self._rate) if math.isfinite(self._rate) else 0
        self._responder = Responder(self.descriptor, self._boot, max(room, 2 * PIECE))

    def _play(self) -> None:
        """Give the responder the samples that are due."""
        if not self._responder.streaming:
            self._last_look = None
            return
        now = time.monotonic()
        if math.isinf(self._rate):
            self._due = float(PIECE if self._drained and not self._wire else 0)
        elif self._last_look is not None:
            self._due += (now - self._last_look) * self._rate
        self._last_look = now
        while self._tape and self._due >= 1:
            block = self._tape[0]
            n = min(int(self._due), len(block.data) - self._position, PIECE)
            self._responder.next_sample = block.first_sample + self._position
            self._responder.sample(block.data[self._position : self._position + n])
            self._due -= n
            self._position += n
            if self._position == len(block.data):
                self._tape.popleft()
                self._position = 0
            while self._markers and (
                not self._tape or self._markers[0].sample < self._responder.next_sample
            ):
                marker = self._markers.popleft()
                self._responder.marker(marker.sample, marker.text)
            # Send now: a delay of this process must not make samples overflow.
            self._send()
        self._responder.finished = not self._tape

    def _send(self) -> None:
        """Send as much of the prepared frames as the line accepts."""
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
        """Wait for the host's bytes until samples are due. Return the bytes; b"" if none came."""
        wait = TICK
        if self._responder.streaming and self._tape:
            until_due = (FRAME_SAMPLES - self._due) / self._rate
            wait = min(max(until_due, 0.0), TICK) if not self._wire else TICK
        listening = [self._terminal] if self._responder.listens else []
        full = [self._terminal] if self._wire else []
        readable, _, _ = select.select(listening, full, [], wait)
        return self._terminal.read() if readable else b""

    def _hear(self, data: bytes, once: bool) -> bool:
        """Process bytes from the host. Return True once the whole recording was sent."""
        sent = not self._tape and self._drained and not self._wire
        is_last_epoch = self._epoch_index + 1 == len(self._epochs)
        has_hello = any(frame.type == FrameType.HELLO for frame in self._decoder.feed(data))
        if has_hello and sent and not (once and is_last_epoch):
            self._begin((self._epoch_index + 1) % len(self._epochs))
        self._responder.hear(data)
        return sent and is_last_epoch


def _epochs(recording: Recording) -> Iterator[tuple[list[Block], list[Marker]]]:
    """Yield blocks and markers of each epoch that has samples."""
    for epoch, blocks in groupby(recording.stretches, lambda block: block.epoch):
        markers = [m for m in recording.markers if m.epoch == epoch]
        yield list(blocks), sorted(markers, key=lambda m: m.sample)
