"""A program that closes a hand which takes its time to let go: until a line comes.

It prints "closing" in its block, "letting go" where the hand begins to let go, and "let go" where
it has. Ending it meanwhile is what its tests try.
"""

from __future__ import annotations

import sys
import threading
from math import inf

from firstcontact.core import Command
from firstcontact.grasp import Hand, HandLimits, SafeHand


class SlowHand(Hand):
    """Lets go when it is told a line."""

    name = "slow"
    limits = HandLimits(speed=0.1, force=5.0, rate=100.0, watchdog=inf)

    def send(self, command: Command) -> None:
        """Take it."""

    def release(self) -> None:
        """Nothing to be seen of it."""

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
