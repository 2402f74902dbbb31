"""Device on a pseudo terminal; tests decide every sample, fault and reset."""

import os
import select
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from numbered import DESCRIPTOR, check, numbered

from firstcontact.device import Arrival, Descriptor, Source
from firstcontact.device.ports import PseudoTerminal
from firstcontact.device.protocol import FrameType, decode, encode
from firstcontact.device.responder import Responder
from firstcontact.device.serial_source import SerialSource

#: What takes longer will never come, s.
DEAD = 60.0


@dataclass
class Script:
    """Faults that the device makes. Frames include their final zero."""

    sends: Callable[[bytes], bytes] = lambda frame: frame
    hears: Callable[[bytes], bytes] = lambda data: data


class ScriptedDevice:
    """Device that sends only the samples from :meth:`put`."""

    def __init__(
        self,
        path: Path,
        boot: int = 1,
        room: int = 100_000,
        descriptor: Descriptor = DESCRIPTOR,
        responder: Callable[[Descriptor, int, int], Responder] = Responder,
    ) -> None:
        self.script = Script()
        self._make = responder
        self.resting = False
        self._room = room
        self._changed = threading.Condition()
        self._terminal = PseudoTerminal(path)
        self._wire = b""
        self._wake, self._poke = os.pipe()
        self.reset(boot, descriptor)
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        self.port = str(path)

    def reset(self, boot: int, descriptor: Descriptor = DESCRIPTOR) -> None:
        """Restart the device: it counts from 0 and sends nothing yet.

        Unsent samples are lost, and so are bytes of the host that the device has not read.
        """
        with self._changed:
            if self._terminal.plugged:
                self._terminal.read()
            self._wire = b"\0" if self._wire else b""
            self._responder = self._make(descriptor, boot, self._room)
            os.write(self._poke, b".")

    def unplug(self) -> None:
        with self._changed:
            self._terminal.unplug()
            self._wire = b""
            os.write(self._poke, b".")

    def plug(self) -> None:
        with self._changed:
            self._terminal.plug()
            os.write(self._poke, b".")

    def put(self, count: int) -> None:
        """Send ``count`` samples, five in a frame, once the host has started them."""
        with self._changed:
            assert self._changed.wait_for(lambda: self._responder.streaming, DEAD)
            self._responder.sample(numbered(self._responder.next_sample, count))
            os.write(self._poke, b".")

    def count_samples(self, count: int) -> None:
        """Count samples, whether or not the host has started them."""
        with self._changed:
            self._responder.sample(numbered(self._responder.next_sample, count))

    @contextmanager
    def sending(self, rate: float = 12_500.0) -> Iterator[None]:
        """Send samples at a rate until the end of the block, but none while ``resting`` is true."""
        over = threading.Event()

        def go_on() -> None:
            begin = time.monotonic() - self.next_sample / rate
            while not over.wait(2e-3):
                due = int((time.monotonic() - begin) * rate) - self.next_sample
                if self.resting:
                    begin += due / rate
                elif due > 0:
                    self.count_samples(due)
                    os.write(self._poke, b".")

        thread = threading.Thread(target=go_on, daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    @contextmanager
    def stuck(self) -> Iterator[None]:
        """Read and send nothing until the end of the block."""
        with self._changed:
            yield

    @property
    def responder(self) -> Responder:
        """Responder that was made at the last reset."""
        return self._responder

    @property
    def next_sample(self) -> int:
        with self._changed:
            return self._responder.next_sample

    def close(self) -> None:
        os.close(self._poke)
        self._thread.join()
        os.close(self._wake)
        self._terminal.unplug()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _run(self) -> None:
        while True:
            with self._changed:
                terminal = self._terminal.fileno()
            reading = [self._wake] + ([terminal] if terminal >= 0 else [])
            writing = [terminal] if terminal >= 0 and self._wire else []
            try:
                ready, _, _ = select.select(reading, writing, [], DEAD)
            except OSError:  # unplugged meanwhile
                continue
            if self._wake in ready and not os.read(self._wake, 4096):
                return
            with self._changed:
                if self._terminal.plugged and self._terminal.fileno() == terminal:
                    if terminal in ready and self._responder.listens:
                        self._responder.hear(self.script.hears(self._terminal.read()))
                    self._send()
                self._changed.notify_all()

    def _send(self) -> None:
        while True:
            while len(self._wire) < 4096 and (frame := self._responder.frame()):
                self._wire += self.script.sends(frame)
            sent = self._terminal.write(self._wire) if self._wire else 0
            self._wire = self._wire[sent:]
            if not sent:
                return


def collect(source: Source, enough: Callable[[int], bool]) -> list[Arrival]:
    """Read until there are enough samples. Assert that each has its own number."""
    arrivals: list[Arrival] = []
    count = 0
    while not enough(count):
        new = source.read(DEAD)
        assert new, f"nothing more came after {count} samples; {source.health}"
        arrivals += new
        count += sum(len(a.block.data) for a in new)
    check(a.block for a in arrivals)
    return arrivals


def samples(arrivals: list[Arrival]) -> int:
    return sum(len(a.block.data) for a in arrivals)


def read_until(source: SerialSource, condition: Callable[[], object]) -> list[Arrival]:
    """Read arrivals until a condition is true."""
    arrivals: list[Arrival] = []
    while not condition():
        assert not source.ended
        arrivals += source.read(0.05)
    return arrivals


def every_other(count: int, sends: Callable[[bytes], bytes]) -> Callable[[bytes], bytes]:
    """Return a fault that changes each ``count``-th samples frame, except the first."""
    count_seen = 0

    def change(frame: bytes) -> bytes:
        nonlocal count_seen
        if decode(frame[:-1]).type != FrameType.SAMPLES:
            return frame
        count_seen += 1
        return sends(frame) if count_seen % count == 0 else frame

    return change


def answer_frame(kind: FrameType, payload: bytes) -> Callable[[bytes], bytes]:
    return lambda frame: encode(kind, decode(frame[:-1]).counter, payload)
