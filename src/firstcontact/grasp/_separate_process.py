"""The process that a hand has for itself.

Started by :class:`firstcontact.grasp._separate.SeparateHand`, one order a line on its standard
input, each answered with a line. It imports no arrays and computes nothing: it is never late.
"""

from __future__ import annotations

import os
import select
import signal
import sys
from importlib import import_module

from firstcontact.core import Command, InputError, in_a_line
from firstcontact.grasp._hand import Hand, HandError

#: From the end of the orders to that of the process, s at most: the Ability Hand opens in 2.
ENDED = 5.0


class Orders:
    """What comes through the pipe, to a hand.

    Parameters
    ----------
    hand
        Open.
    silence
        Without an order for so long the hand is released, s.
    out
        Descriptor for answers.
    """

    def __init__(self, hand: Hand, silence: float, out: int) -> None:
        self._hand = hand
        self._silence = silence
        self._out = out

    def serve(self) -> None:
        """Obey until standard input ends."""
        part = b""
        while True:
            if not select.select([0], [], [], self._silence)[0]:
                self._hand.release()
                continue
            data = os.read(0, 4096)
            if not data:
                return
            *lines, part = (part + data).split(b"\n")
            for line in lines:
                say(self._out, self._obey(line.decode().split()))

    def _obey(self, words: list[str]) -> str:
        try:
            match words:
                case ["send", speed, force]:
                    self._hand.send(Command(float(speed), float(force)))
                case _:
                    self._hand.release()
        except HandError as error:
            return f"failed {error}"
        except Exception as error:
            return f"failed it raised {in_a_line(error)}"
        return "done"


def say(out: int, line: str) -> None:
    """Tell the program a line; one that is gone is not told."""
    try:
        os.write(out, line.replace("\n", " ").encode() + b"\n")
    except OSError:
        return


def main() -> None:
    """Be the hand's process until standard input ends."""
    parent = os.getppid()
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    # It is woken when the program is gone; whatever holds it then, the system ends it.
    signal.signal(signal.SIGCONT, lambda *_: None if os.getppid() == parent else _end_within(ENDED))
    # What the hand's package prints is not for the pipe.
    out = os.dup(1)
    os.dup2(2, 1)
    module, name, silence, *port = sys.argv[1:]
    try:
        hand: Hand = getattr(import_module(module), name)(port[0] if port else None)
        with hand:
            say(out, "ready")
            Orders(hand, float(silence), out).serve()
            _end_within(ENDED)
    except (InputError, HandError) as error:
        say(out, f"refused {error}")
    except Exception as error:
        say(out, f"refused the hand {name} raised {in_a_line(error)}")


def _end_within(seconds: float) -> None:
    signal.setitimer(signal.ITIMER_REAL, seconds)


if __name__ == "__main__":
    main()
