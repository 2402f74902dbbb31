"""Twin (simulated hand) as a serial device in a child process, and a source that opens it."""

from __future__ import annotations

import json
import shutil
import threading
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Self

from firstcontact.core import DeviceError
from firstcontact.core.installation import load_compiled
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device.opening import SourceOptions, check_speed
from firstcontact.device.serial_source import SerialSource
from firstcontact.device.twin_process import TwinOptions
from firstcontact.jobs import Child

#: Largest speed, as a multiple of real time. No host reaches it.
FASTEST = 1e6
#: Longest wait for the start, s. It takes a second.
START = 120.0
#: Longest wait for an answer, and for the end of the process, s.
PATIENCE = 3.0
#: Largest amount of received samples that wait for the reader, s, if the twin is faster than real
#: time. Data on the line are not included.
AHEAD = 0.25


class TwinDevice:
    """Child process that simulates the twin on a pseudo terminal. Open its ``port``."""

    def __init__(self, options: TwinOptions) -> None:
        check_speed(options.speed, FASTEST)
        self._lock = threading.Lock()
        self._child = Child("firstcontact.device.twin_process", json.dumps(asdict(options)))
        #: Path to open as a serial port.
        self.port = ""
        try:
            word, _, argument = self._answer(START).partition(" ")
            if word != "ready":
                raise DeviceError(
                    argument or "the twin's process did not start: see what it printed"
                )
            self.port = argument
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        return self._child.pid

    def positions_since(self, since: float) -> list[tuple[float, float]]:
        """Return (time, s; travel, m) pairs later than ``since``, s of the samples' clock."""
        _, *pairs = self._ask(f"positions {since!r}").split()
        return [(float(at), float(x)) for at, x in (pair.split(",") for pair in pairs)]

    def unplug(self) -> None:
        self._ask("unplug")

    def plug(self) -> None:
        self._ask("plug")

    def close(self) -> None:
        """End the process and remove its port, within seconds. A second call does nothing."""
        # Another thread may be waiting for an answer: let it finish, within limits.
        has_lock = self._lock.acquire(timeout=PATIENCE)
        try:
            if not self._child.end(PATIENCE) and self.port:
                shutil.rmtree(Path(self.port).parent, ignore_errors=True)
        finally:
            if has_lock:
                self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _ask(self, word: str) -> str:
        answer = ""
        with self._lock, suppress(OSError):
            self._child.tell(word, PATIENCE)
            answer = self._answer(PATIENCE)
        if not answer:
            raise DeviceError("the twin's process has ended: open another twin")
        return answer

    def _answer(self, timeout: float) -> str:
        try:
            return self._child.answer(timeout)
        except TimeoutError as error:
            raise DeviceError(
                f"the twin's process has not answered for {timeout:g} s: open another twin"
            ) from error
        except OSError:
            return ""


class TwinSource(SerialSource):
    """Source for the twin. It starts a :class:`TwinDevice` and opens the device's port."""

    def __init__(self, options: TwinOptions) -> None:
        super().__init__("twin")
        self._options = options
        self.device: TwinDevice | None = None
        self.speed = options.speed
        self.twin_hand = options.condition, options.seed
        if self.speed > 1.0:  # the device waits for the reader, so that orders take effect soon
            self.most = round(AHEAD * FINGERTIP_RATE)

    def positions_since(self, since: float) -> list[tuple[float, float]]:
        return [] if self.device is None else self.device.positions_since(since)

    def __enter__(self) -> Self:
        self.device = TwinDevice(self._options)
        self.port = self.device.port
        try:
            return super().__enter__()
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        try:
            super().close()
        finally:
            if self.device is not None:
                self.device.close()


def from_name(name: str, options: SourceOptions) -> TwinSource:
    load_compiled("firstcontact.twin._compiled")
    check_speed(options.speed, FASTEST)  # before a model is trained
    values = {**asdict(options), "objects": [options.objects]}
    return TwinSource(TwinOptions(**values))


def shore_a(name: str) -> float:
    from firstcontact.twin import find_object

    return find_object(name).shore_a
