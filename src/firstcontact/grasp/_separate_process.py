"""Separate process that drives one hand.

:class:`firstcontact.grasp._separate.SeparateHand` starts it. It reads one order per line from
standard input and answers each with one line. It imports no NumPy and computes nothing, so that
it always answers in time.
"""

from __future__ import annotations

import os
import select
import signal
import sys
from importlib import import_module

from firstcontact.core import Command, InputError, summarize_error
from firstcontact.grasp._hand import Hand, HandError

#: Longest time from the end of the orders to the end of the process, s. The Ability Hand needs
#: 2 s of it to open.
ENDED = 5.0
#: Most positions in an answer, so that it fits into a pipe.
MOST_POSITIONS = 60


class Orders:
    """Loop that reads orders from the pipe and passes them to a hand."""

    def __init__(self, hand: Hand, silence: float, out: int) -> None:
        self._hand = hand
        self._silence = silence
        self._out = out

    def serve(self) -> None:
        """Carry out orders until standard input ends."""
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
                write_line(self._out, self._obey(line.decode().split()))

    def _obey(self, words: list[str]) -> str:
        try:
            match words:
                case ["send", speed, force]:
                    self._hand.send(Command(float(speed), float(force)))
                case ["positions"]:
                    latest = list(self._hand.positions())[-MOST_POSITIONS:]
                    pairs = [f"{float(at)!r},{float(travel)!r}" for at, travel in latest]
                    return " ".join(["done", *pairs])
                case _:
                    self._hand.release()
        except HandError as error:
            return f"failed {error}"
        except Exception as error:
            return f"failed it raised {summarize_error(error)}"
        return "done"


def write_line(out: int, line: str) -> None:
    """Write a line to the program. Ignore the error if the program has ended."""
    try:
        os.write(out, line.replace("\n", " ").encode() + b"\n")
    except OSError:
        return


def main() -> None:
    """Drive the hand until standard input ends."""
    parent = os.getppid()
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(0))
    # SIGCONT arrives when the program ends. The timer ends this process even if a call blocks it.
    signal.signal(signal.SIGCONT, lambda *_: None if os.getppid() == parent else _end_within(ENDED))
    # Output that the hand's package prints must not enter the pipe.
    out = os.dup(1)
    os.dup2(2, 1)
    module, name, silence, *port = sys.argv[1:]
    try:
        hand: Hand = getattr(import_module(module), name)(port[0] if port else None)
        with hand:
            write_line(out, "ready")
            Orders(hand, float(silence), out).serve()
            _end_within(ENDED)
    except (InputError, HandError) as error:
        write_line(out, f"refused {error}")
    except Exception as error:
        write_line(out, f"refused the hand {name} raised {summarize_error(error)}")


def _end_within(seconds: float) -> None:
    signal.setitimer(signal.ITIMER_REAL, seconds)


if __name__ == "__main__":
    main()
