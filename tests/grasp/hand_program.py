"""Program that closes a hand, for tests that end the program.

Arguments: the hand's name ("slow" for one that waits for a line when it is closed, "send" or
"release" for one that blocks there), its port or "-", and the action after closing: ``wait`` for a
signal, ``raise``, ``exit``, ``hang`` without a message, stay ``alive`` until a release, or ``hold``
Python's global lock once a line arrives.
"""

import ctypes
import select
import sys
import threading

from firstcontact.core import Command
from firstcontact.grasp import SafeHand, open_hand, separate
from firstcontact.grasp.printing import PrintHand

CLOSE = Command(0.02, 2.0)
#: Longest wait on a busy machine, s.
separate.MUTE = 60.0


class SlowHand(PrintHand):
    """Hand that waits for a line on standard input when it is closed."""

    def close(self) -> None:
        print("letting go", flush=True)
        sys.stdin.readline()
        print("let go", flush=True)


class StuckHand(PrintHand):
    """Hand with a method that never returns."""

    def __init__(self, method: str) -> None:
        super().__init__()
        setattr(self, method, lambda *_: threading.Event().wait())


def make_hand(name: str, port: str) -> SafeHand:
    """Return the named hand, or an Ability Hand that tolerates late answers."""
    if name == "slow":
        return SafeHand(SlowHand())
    if name in ("send", "release"):
        return SafeHand(StuckHand(name))
    if name != "ability":
        return open_hand(name)
    from patient_ability import PatientAbilityHand

    return SafeHand(separate.SeparateHand(PatientAbilityHand, port))


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
            if action == "alive":
                hand.alive()
                if hand.counts.released:
                    break
            if action in ("wait", "hold"):
                hand.send(CLOSE)
            if action == "hold" and select.select([sys.stdin], [], [], 0)[0]:
                # PyDLL, unlike CDLL, keeps the lock during the call, so that no thread runs.
                ctypes.PyDLL(None).pause()


main()
