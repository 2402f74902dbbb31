"""Program with a hand that waits for a line on standard input when it is closed.

It prints "closing" in its ``with`` block, "letting go" when the hand is closed, and "let go" after
the line. Tests end the program in between.
"""

from __future__ import annotations

import sys
import threading
from math import inf

from firstcontact.core import Command
from firstcontact.grasp import Hand, HandLimits, SafeHand


class SlowHand(Hand):
    """Hand that waits for a line on standard input when it is closed."""

    name = "slow"
    limits = HandLimits(speed=0.1, force=5.0, rate=100.0, watchdog=inf)

    def send(self, command: Command) -> None:
        """Ignore the command."""

    def release(self) -> None:
        """Do nothing: :meth:`close` waits for the line."""

    def close(self) -> None:
        print("letting go", flush=True)
        sys.stdin.readline()
        print("let go", flush=True)


def main() -> None:
    never = threading.Event()
    with SafeHand(SlowHand()) as hand:
        hand.send(Command(0.02, 2.0))
        print("closing", flush=True)
        while not never.wait(0.05):
            hand.alive()


main()
