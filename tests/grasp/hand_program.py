"""A program that closes a hand and then does what it is told: for tests that end it.

Arguments: the hand's name, its port or "-", and what to do once it closes: ``wait`` for a signal,
``raise``, ``exit``, ``hang`` without a word, or ``hold`` Python's lock when a line comes.
"""

from __future__ import annotations

import ctypes
import select
import sys
import threading

from firstcontact.core import Command
from firstcontact.grasp import open_hand

CLOSE = Command(0.02, 2.0)


def main() -> None:
    name, port, then = sys.argv[1:]
    never = threading.Event()
    with open_hand(name, None if port == "-" else port) as hand:
        hand.send(CLOSE)
        print("closing", flush=True)
        if then == "raise":
            raise RuntimeError("a bug")
        if then == "exit":
            sys.exit(0)
        while not never.wait(0.05):
            if then in ("wait", "hold"):
                hand.send(CLOSE)
            if then == "hold" and select.select([sys.stdin], [], [], 0)[0]:
                # Unlike CDLL, it calls with the lock held: no thread runs meanwhile.
                ctypes.PyDLL(None).sleep(600)


main()
