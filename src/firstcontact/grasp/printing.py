"""Hand for dry runs, which prints its commands."""

from __future__ import annotations

import sys
import time
from collections import deque
from math import inf
from typing import Self, TextIO

from firstcontact.core import Command
from firstcontact.grasp.hand import Begins, Hand, HandError, HandLimits


class PrintHand(Hand):
    """Hand for a dry run. It prints one line per command, but none for a repeated command."""

    name = "print"
    limits = HandLimits(speed=0.5, force=20.0, rate=200.0, watchdog=inf)
    real = False
    separate = False
    begins = Begins.OTHERS | Begins.US

    def __init__(self, port: str | None = None, out: TextIO | None = None) -> None:
        self.commands: deque[Command | None] = deque(maxlen=1000)
        self._out = out
        self._open = False
        self._began = time.monotonic()

    def send(self, command: Command) -> None:
        if not self._open:
            raise HandError(f"the hand {self.name!r} is not open: use it in a with block")
        self._note(command)

    def release(self) -> None:
        if self._open:
            self._note(None)

    def close(self) -> None:
        self.release()
        self._open = False

    def __enter__(self) -> Self:
        self._open = True
        self._began = time.monotonic()
        return self

    def _note(self, command: Command | None) -> None:
        again = bool(self.commands) and self.commands[-1] == command
        self.commands.append(command)
        if again:
            return
        # A closed terminal must not prevent the release.
        try:
            seconds = time.monotonic() - self._began
            print(f"hand {seconds:9.3f} s  {describe(command)}", file=self._out or sys.stderr)
        except (OSError, ValueError):
            return


def describe(command: Command | None) -> str:
    """Return text about a command. None stands for a release."""
    if command is None:
        return "release"
    if command.speed == 0:
        return f"stop, at most {command.force:.2f} N"
    verb = "close" if command.speed > 0 else "open"
    return f"{verb} at {abs(command.speed) * 1000:.1f} mm/s, at most {command.force:.2f} N"
