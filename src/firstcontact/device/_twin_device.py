"""The twin as a device that is plugged in: a port to open, and nothing else to know.

It runs in a process of its own and costs the host's interpreter nothing. What the hand
takes stands in the samples' own line: at each start of the motor the device sends the
marker "twin: <object>", pinned to that sample. A host that sends the order "object: block
29" has it take only that object from the next closing on (the names are those of
:mod:`firstcontact.twin._objects`); "object: any" goes back to the plan. Every order is answered
with a marker that says what became of it. Marks are words and never orders.

The order "hand: 0.0500 2.000" commands the closing that is going on: 0.05 m/s and 2 N at
most, from the drive's latency on until the hand opens. "hand: release" opens it. When a
closing is over, the marker "twin: peak 3.4 N" says how hard it squeezed, pinned to the
sample where the hand begins to open.
"""

from __future__ import annotations

import shutil
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Self

from firstcontact.core import Child, InputError
from firstcontact.twin import LATENCY

#: It compiles what it needs when it starts for the first time; then it is at hand in a second, s.
START = 120.0
#: Longest wait for an answer, and for an end that was asked for, s.
PATIENCE = 3.0


class TwinDevice:
    """A twin on a pseudo terminal, from here until it is closed.

    It starts to count samples at once, paced by the monotonic clock, and sends them when
    it is told to, as ``docs/protocol.md`` says. It dies with this process, however that
    ends, and takes no notice of Ctrl-C.

    Parameters
    ----------
    condition
        "paper-rig" or "everyday".
    objects
        Names of what the hand takes up; all of the paper's by default.
    seed
        Of everything by chance: the hand is that of ``firstcontact simulate`` with
        this condition and seed.
    speed
        1 for real time; more to have an hour in less, as far as the host keeps up.
    latency
        From a command to the hand to its effect, s of its samples.

    Raises
    ------
    InputError
        Something given is not known, the twin's extra is not installed, or the
        process did not start.

    Notes
    -----
    The methods may be called from any thread. What a host that does not read misses is
    counted by the device after half a second; faster than real time it waits for the host
    instead. An unplugged twin keeps its power: it counts on,
    and drops what cannot wait.
    """

    def __init__(
        self,
        condition: str = "paper-rig",
        objects: Sequence[str] | None = None,
        seed: int = 0,
        speed: float = 1.0,
        latency: float = LATENCY,
    ) -> None:
        if not 0 < speed < float("inf"):
            raise InputError(f"speed is {speed}: use a number above 0")
        options = [f"--condition={condition}", f"--seed={seed}", f"--speed={speed}"]
        options.append(f"--latency={latency}")
        options += [f"--object={name}" for name in objects or ()]
        self._lock = threading.Lock()
        self._child = Child("firstcontact.device._twin_process", *options)
        #: What to open as a serial port.
        self.port = ""
        try:
            word, _, rest = self._answer(START).partition(" ")
            if word != "ready":
                raise InputError(rest or "the twin's process did not start: see what it printed")
            self.port = rest
        except BaseException:
            self.close()
            raise

    @property
    def pid(self) -> int:
        """Of the twin's process."""
        return self._child.pid

    def reset(self) -> None:
        """Have the device restart: another boot, samples from 0, silent until started."""
        self._tell("reset")

    def unplug(self) -> None:
        """Pull the cable: the port is gone under whoever has it open."""
        self._tell("unplug")

    def plug(self) -> None:
        """Put the cable back: the port is there again under the same name."""
        self._tell("plug")

    def close(self) -> None:
        """End the twin and its port, within seconds whatever it does. Closing twice is fine."""
        # Another thread that waits for an answer is let finish, but not for ever.
        held = self._lock.acquire(timeout=PATIENCE)
        try:
            if not self._child.end(PATIENCE) and self.port:
                shutil.rmtree(Path(self.port).parent, ignore_errors=True)
        finally:
            if held:
                self._lock.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def _tell(self, word: str) -> None:
        with self._lock:
            try:
                self._child.tell(word, PATIENCE)
                answer = self._answer(PATIENCE)
            except OSError as error:
                raise InputError("the twin's process has ended: open another twin") from error
            if answer != "done":
                raise InputError("the twin's process has ended: open another twin")

    def _answer(self, timeout: float) -> str:
        try:
            return self._child.answer(timeout)
        except TimeoutError as error:
            raise InputError(
                f"the twin's process has not answered for {timeout:g} s: open another twin"
            ) from error
        except OSError:
            return ""
