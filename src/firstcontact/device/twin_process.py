"""Child process that simulates the twin as a serial device, until its standard input ends."""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from firstcontact import __version__
from firstcontact.core import ArgumentError, Command, InputError, fingertip_layout
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.device.descriptor import Descriptor
from firstcontact.device.ports import PseudoTerminal, port_folder
from firstcontact.device.protocol import FRAME_SAMPLES
from firstcontact.device.responder import RING, TerminalDevice
from firstcontact.device.twin_words import (
    ACCEPTED,
    CLOSE_ORDER,
    HAND,
    OBJECT,
    TESTER,
    TWIN,
    lost_text,
    peak_text,
    read_order,
)
from firstcontact.twin.drive import LATENCY

if TYPE_CHECKING:
    from firstcontact.twin.bench import BenchStream

#: Shortest time between two checks of the clock, s.
TICK = 1e-3


@dataclass(frozen=True, slots=True)
class TwinOptions:
    """Options of a simulated hand. ``fault`` is the name of a defect of its fingertips."""

    condition: str = "paper-rig"
    objects: Sequence[str] | None = None
    seed: int = 0
    speed: float = 1.0
    latency: float = LATENCY
    fault: str = ""


class TwinProcess(TerminalDevice):
    def __init__(self, terminal: PseudoTerminal, options: TwinOptions) -> None:
        # Late, because its import takes a while.
        from firstcontact.twin import TwinStream
        from firstcontact.twin.bench import BenchStream
        from firstcontact.twin.sensor import DeviceFilter

        super().__init__(terminal)
        self._rate = FINGERTIP_RATE * options.speed
        self._waits = options.speed > 1.0
        # A batch fills complete frames, and at most one batch is due per tick.
        self._batch = FRAME_SAMPLES * max(1, round(self._rate * TICK / FRAME_SAMPLES))
        # A twin that waits for the host needs no long ring. In a long ring, more markers would wait
        # than the queue of markers holds.
        ring = round(RING * (FINGERTIP_RATE if self._waits else self._rate))
        ring = max(ring, 2 * self._batch)
        condition, seed, fault = options.condition, options.seed, options.fault
        self._stream = TwinStream(condition, options.objects, seed, options.latency)
        self._filter = DeviceFilter()
        # Fingertips on a bench, with the fault, from the first order to their tester on.
        self._make_bench = partial(BenchStream, condition, seed, fault)
        self._bench: BenchStream | None = self._make_bench() if fault else None
        self._announced = -1
        self._begin = time.monotonic()
        self._made = 0
        self._restart(DESCRIPTOR, ring, self._obey)

    def run(self) -> None:
        while True:
            behind = self._catch_up()
            now = time.monotonic()
            if self._bench is None or self._bench.link.release(now) <= now:
                self._send()
            next_batch = self._begin + (self._made + self._batch) / self._rate
            wait = 0.0 if behind else max(next_batch - time.monotonic(), 0.0)
            readable = self._wait(wait, 0)
            if self._terminal in readable:
                self._responder.hear(self._terminal.read())
            if 0 in readable and not self._command():
                return

    def _catch_up(self) -> bool:
        """Simulate the next batch of samples if its time has come.

        Return True if the batch after that one is due, too.
        """
        due = int((time.monotonic() - self._begin) * self._rate) - self._made
        if due < self._batch:
            return False
        if self._waits and self._terminal.plugged and self._responder.room < self._batch:
            # Time spent waiting for the host is not caught up later.
            self._begin = time.monotonic() - self._made / self._rate
            return False
        stream = self._stream if self._bench is None else self._bench
        data = self._filter.update(stream.read(self._batch))
        self._responder.sample(data)
        self._made += self._batch
        if self._bench is None:
            self._announce()
        return due >= 2 * self._batch

    def _next_frame(self) -> bytes:
        frame = super()._next_frame()
        while self._bench is not None and self._responder.streaming and self._bench.link.loses():
            frame = super()._next_frame()
        return frame

    def _announce(self) -> None:
        """Send markers about new closings: which object, the largest force, and if it was lost."""
        words: list[tuple[int, str]] = []
        for pinch in reversed(self._stream.pinches):
            words.append((pinch.start, f"{TWIN}{pinch.label.object}"))
            if pinch.end is not None:
                words += [(pinch.end, peak_text(pinch.peak))] if pinch.peak is not None else []
                words += [(pinch.end, lost_text(pinch.lost))] if pinch.lost is not None else []
            if pinch.start <= self._announced:
                break
        for sample, text in sorted(words):
            if self._announced < sample < self._stream.sample:
                self._responder.marker(sample, text)
        self._announced = self._stream.sample - 1

    def _obey(self, text: str) -> str:
        """Carry out an order that concerns the object, the hand or the simulated tester.

        Return the text of the answer.
        """
        try:
            if text.startswith(OBJECT):
                name = text.removeprefix(OBJECT).strip()
                self._stream.choose(None if name == "any" else name)
            elif text.startswith(TESTER):
                self._bench = self._bench or self._make_bench()
                self._bench.obey(text.removeprefix(TESTER).strip())
            elif text == CLOSE_ORDER:
                self._stream.close()
            elif text.startswith(HAND):
                return self._move(text, read_order(text))
            else:
                raise ArgumentError(f"begin an order with {OBJECT!r}, {HAND!r} or {TESTER!r}")
        except InputError as error:
            return f"{TWIN}hand order {text!r} is not valid: {error}"
        return f"{ACCEPTED}{text}"

    def _move(self, text: str, order: Command | None) -> str:
        if order is None:
            self._stream.release()
        elif not self._stream.command(order):
            return f"{TWIN}hand is not closing, command {self._stream.ignored} ignored, {text}"
        return f"{ACCEPTED}{text}"

    def _command(self) -> bool:
        """Carry out commands from the parent process. Return False if it has closed the pipe."""
        lines = os.read(0, 4096)
        for line in lines.splitlines():
            answer = "done"
            match line.split():
                case [b"positions", since]:
                    steps = self._stream.positions.since(float(since))
                    answer = " ".join([answer, *(f"{at!r},{x!r}" for at, x in steps)])
                case [b"unplug"]:
                    self._terminal.unplug()
                    self._wire = b""
                case [b"plug"]:
                    self._terminal.plug()
            say(answer)
        return bool(lines)


DESCRIPTOR = Descriptor(
    fingertip_layout(),
    firmware=f"firstcontact {__version__} (twin)",
    sensor="simulated fingertip",
    hand="simulated hand",
    source="twin",
)


def say(line: str) -> None:
    """Send a line to the parent process, if the parent still runs."""
    try:
        sys.stdout.write(line + "\n")
        sys.stdout.flush()
    except BrokenPipeError:
        return


def main() -> None:
    # Ctrl-C in a terminal is meant for the host. SIGTERM removes the link first.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    with port_folder() as folder:
        terminal = PseudoTerminal(folder / "port")
        try:
            twin = TwinProcess(terminal, TwinOptions(**json.loads(sys.argv[1])))
        except InputError as error:
            say(f"refused {error}")
            return
        say(f"ready {terminal.path}")
        try:
            twin.run()
        finally:
            terminal.unplug()


if __name__ == "__main__":
    main()
    # Everything is cleaned up. Python's and the compiler's own shutdown would take a second or
    # more.
    os._exit(0)
