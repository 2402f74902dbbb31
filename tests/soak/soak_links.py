"""Senders of numbered samples for the soak, one for each kind of source, with faults."""

import os
import subprocess
import sys
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from random import Random
from typing import Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

# What plays the devices of other tests plays them here.
sys.path[:0] = [str(Path(__file__).parents[1] / "device"), str(Path(__file__).parents[1])]

from lsl_outlet import MODULUS, ask, start_outlet  # noqa: E402
from printing_board import PrintingBoard  # noqa: E402
from scripted_device import ScriptedDevice  # noqa: E402

from firstcontact.device import Source, open_source  # noqa: E402
from firstcontact.device.protocol import FrameType, decode  # noqa: E402
from sound import local_sound, ramp  # noqa: E402

RATE = 4936.0
#: Factor that makes consecutive numbers jump about, modulo a power of two.
SCATTER = 7919
#: What is on its way has come after so long, s.
ARRIVED = 1.5


class Link(ABC):
    """Sender with its source and its possible faults.

    Attributes
    ----------
    modulus
        Samples contain their numbers modulo this value.
    continuous
        True if samples that were sent between two epochs count as lost.
    restarts
        True if the sender counts from 0 again in each epoch.
    slack
        Largest error of the length of a gap, samples; 0 if the sender counts or stamps its samples.
    last
        Number of the last sample that was sent, by epoch.
    faults
        Possible faults, by name.
    """

    modulus = MODULUS
    continuous = False
    restarts = False
    slack = 0

    def __init__(self, folder: Path, rng: Random) -> None:
        self.folder, self.rng = folder, rng
        self.last: dict[int, int] = {}
        self.faults: dict[str, Callable[[], None]] = {}

    @abstractmethod
    def opened(self) -> Any:
        """Start the sender and open its source. Yield the source."""

    @abstractmethod
    def finish(self) -> None:
        """Stop sending, wait for all samples, and store the last number."""

    def numbers(self, data: NDArray[Any]) -> NDArray[np.int64]:
        """Return the numbers in the samples, modulo :attr:`modulus`."""
        return np.rint(data[:, 0]).astype(np.int64)


class PortLink(Link):
    """Simulated device on a pseudo terminal."""

    modulus = 2**32
    continuous = True

    @contextmanager
    def opened(self) -> Iterator[Source]:
        path = self.folder / "port"
        with ScriptedDevice(path, room=round(RATE / 2)) as device, device.sending(RATE):
            self.device = device
            self.faults = {
                "unplugged": self._unplug,
                "silent": lambda: self._pause(3.0),
                "burst": lambda: device.hold(self.rng.choice((0.2, 1.0))),
                "damaged frames": lambda: self._spoil(self._flipped),
                "lost frames": lambda: self._spoil(lambda frame: b""),
                "doubled frames": lambda: self._spoil(lambda frame: 2 * frame),
                "noise": lambda: self._spoil(lambda frame: b"\xff\x80\0" + frame),
            }
            with open_source(device.port) as source:
                yield source

    def numbers(self, data: NDArray[Any]) -> NDArray[np.int64]:
        counts = np.ascontiguousarray(data[:, :2]).astype("<i2").view("<u4")
        return counts[:, 0].astype(np.int64)

    def finish(self) -> None:
        self.device.resting = True
        time.sleep(ARRIVED)
        self.last[0] = self.device.next_sample - 1

    def _unplug(self) -> None:
        self.device.unplug()
        time.sleep(self.rng.uniform(0.1, 3.0))
        self.device.plug()

    def _pause(self, seconds: float) -> None:
        self.device.resting = True
        time.sleep(seconds)
        self.device.resting = False

    def _spoil(self, spoilt: Callable[[bytes], bytes]) -> None:
        """Apply a fault to each seventh samples frame, for some seconds."""
        seen = 0

        def sends(frame: bytes) -> bytes:
            nonlocal seen
            seen += decode(frame[:-1]).type == FrameType.SAMPLES
            return spoilt(frame) if seen % 7 == 6 else frame

        self.device.script.sends = sends
        time.sleep(0.5)
        self.device.script.sends = lambda frame: frame

    def _flipped(self, frame: bytes) -> bytes:
        at = self.rng.randrange(len(frame) - 1)
        return frame[:at] + bytes([frame[at] % 255 + 1]) + frame[at + 1 :]


class LslLink(Link):
    """Program that sends an LSL stream."""

    restarts = True

    @contextmanager
    def opened(self) -> Iterator[Source]:
        self.name = f"soak {uuid4().hex}"
        self.faults = {
            "sender gone": self._restart,
            "silent": lambda: self._ask("hold 3"),
            "burst": lambda: self._ask("hold 0.4"),
            "lost": lambda: self._ask(f"lose {self.rng.randrange(1, 2000)}"),
            "NaN": lambda: self._ask(f"nan {self.rng.randrange(1, 500)}"),
            "1e300": lambda: self._ask(f"huge {self.rng.randrange(1, 500)}"),
        }
        with ExitStack() as ends:
            ends.callback(lambda: self.sender.kill())
            self._start()
            with open_source(f"lsl:{self.name}#count") as source:
                yield source

    def finish(self) -> None:
        time.sleep(ARRIVED)  # faults that were asked for last
        self._ask("rest")
        self.last[len(self.last)] = int(self.sender.stdout.readline())
        time.sleep(ARRIVED)

    def _start(self) -> None:
        self.sender = start_outlet(self.name, RATE)
        self.heard = False

    def _ask(self, request: str) -> None:
        assert self.sender.stdout is not None
        if not self.heard:  # on a busy machine the source may take seconds to come back
            assert self.sender.stdout.readline() == "heard\n"
            self.heard = True
        ask(self.sender, request)

    def _restart(self) -> None:
        self.finish()
        self._ask("end")
        self.sender.wait()
        time.sleep(self.rng.uniform(0.0, 2.0))
        self._start()


class LinesLink(Link):
    """Board that prints lines of numbers."""

    @contextmanager
    def opened(self) -> Iterator[Source]:
        self.held = 0.0
        self.line: Callable[[int], bytes] = self._counted
        self.faults = {
            "unplugged": self._unplug,
            "silent": lambda: self._hold(3.0),
            "burst": lambda: self._hold(0.4),
            "lost": lambda: self._spoil(lambda n: b""),
            "damaged": lambda: self._spoil(lambda n: b"\xff\xfe12,,x\n"),
            "NaN": lambda: self._spoil(lambda n: b"%d,nan\n" % n),
            "1e300": lambda: self._spoil(lambda n: b"%d,1e300\n" % n),
            "wild count": lambda: self._spoil(lambda n: b"1e300,5\n"),
        }
        with PrintingBoard(self.folder / "port", self._printed, RATE) as self.board:
            for _ in range(10):  # a machine that does much else measures another rate
                with open_source(f"csv:{self.board.port}#2") as source:
                    if f" {RATE:.1f} Hz" in source.descriptor.firmware:
                        yield source
                        return
            raise AssertionError("the rate could not be measured")

    def finish(self) -> None:
        self.held = time.monotonic() + 1e9
        time.sleep(ARRIVED)
        self.last[len(self.last)] = self.board.printed - 1

    def numbers(self, data: NDArray[Any]) -> NDArray[np.int64]:
        return super().numbers(data) * pow(SCATTER, -1, self.modulus) % self.modulus

    def _counted(self, number: int) -> bytes:
        # A second column that counted would be as good a counter as the first.
        return b"%d,%d\n" % (number, SCATTER * number % self.modulus)

    def _printed(self, number: int) -> bytes:
        while time.monotonic() < self.held and not self.board.ends:
            time.sleep(0.005)
        return self.line(number)

    def _hold(self, seconds: float) -> None:
        self.held = time.monotonic() + seconds
        time.sleep(seconds)

    def _spoil(self, line: Callable[[int], bytes]) -> None:
        self.line = lambda n: line(n) if n % 100 == 50 else self._counted(n)
        time.sleep(0.5)
        self.line = self._counted

    def _unplug(self) -> None:
        self.finish()
        self.board.unplug()
        time.sleep(self.rng.uniform(0.3, 3.0))
        self.board.plug()
        time.sleep(0.5)
        self.held = 0.0


class SoundLink(Link):
    """Simulated sound input with samples at the models' rate, so that nothing is resampled."""

    modulus = 65536
    slack = 2  # an overflow is as long as PortAudio's times say

    @contextmanager
    def opened(self) -> Iterator[Source]:
        self.faults = {
            "overflow": lambda: self._stop(0.5),
            "burst": lambda: self._stop(0.005),
        }
        tape = ramp(self.modulus)
        with (
            local_sound(self.folder, tape, loop=1, rate=round(RATE)),
            open_source("audio:disc") as source,
        ):
            yield source

    def finish(self) -> None:
        time.sleep(ARRIVED)

    def numbers(self, data: NDArray[Any]) -> NDArray[np.int64]:
        return np.rint(data[:, 0].astype(np.float64) * 32768.0).astype(np.int64) % self.modulus

    def _stop(self, seconds: float) -> None:
        """Stop the whole program for some seconds."""
        me = os.getpid()
        command = f"kill -STOP {me}; sleep {seconds}; kill -CONT {me}"
        subprocess.run(["sh", "-c", command], check=True)


LINKS: dict[str, type[Link]] = {
    "pty": PortLink,
    "lsl": LslLink,
    "csv": LinesLink,
    "sound": SoundLink,
}
