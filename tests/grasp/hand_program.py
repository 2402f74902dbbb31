"""Program that closes a hand, for tests that end the program.

Arguments: the hand's name ("slow" for one that waits for a line when it is closed), its port or
"-", and the action after closing: ``wait`` for a signal, ``raise``, ``exit``, ``hang`` without a
message, or ``hold`` Python's global lock once a line arrives.
"""

from __future__ import annotations

import ctypes
import select
import sys
import threading

from firstcontact.core import Command
from firstcontact.grasp import SafeHand, _separate, open_hand
from firstcontact.grasp._printing import PrintHand

CLOSE = Command(0.02, 2.0)
#: Longest wait on a busy machine, s.
_separate.MUTE = 60.0


class SlowHand(PrintHand):
    """Hand that waits for a line on standard input when it is closed."""

    def close(self) -> None:
        print("letting go", flush=True)
        sys.stdin.readline()
        print("let go", flush=True)


def make_hand(name: str, port: str) -> SafeHand:
    """Return the named hand, or an Ability Hand that tolerates late answers."""
    if name == "slow":
        return SafeHand(SlowHand())
    if name != "ability":
        return open_hand(name)
    from patient_ability import PatientAbilityHand

    return SafeHand(_separate.SeparateHand(PatientAbilityHand, port))


def main() -> None:
    name, port, action = sys.argv[1:]
    never = threading.Event()
    with make_hand(name, port) as hand:
        hand.send(CLOSE)
        print("closing", flush=True)
        if action == "raise":
            raise RuntimeError("a bug")
        if action == "exit":
            sys.exit(0)
        while not never.wait(0.05):
            if action in ("wait", "hold"):
                hand.send(CLOSE)
            if action == "hold" and select.select([sys.stdin], [], [], 0)[0]:
                # PyDLL, unlike CDLL, keeps the lock during the call, so that no thread runs.
                ctypes.PyDLL(None).sleep(600)


main()
