"""Program that reads standard input as ``live`` does, and prints the requests to a hand in it."""

import os
import sys
import threading

from firstcontact.cli.session_keys import session_keys
from firstcontact.core import InputError
from firstcontact.streaming.events import Ask

ended = threading.Event()


def say(words: str) -> None:
    """Write a whole line in one call, because two threads write."""
    os.write(1, f"{words}\n".encode())


class Session:
    """Stand-in for a session that prints each request."""

    closed = False
    uses_shape = True

    def new_object(self) -> None:
        say("new object")

    def hand_asks(self) -> tuple[Ask, ...]:
        return () if "--no-hand" in sys.argv else tuple(Ask)

    def ask_hand(self, ask: Ask, by: str) -> None:
        if ask is Ask.CLOSE and self.closed:
            say(f"again by {by}")
            ended.set()
            raise InputError("it is closed already")
        self.closed = ask is Ask.CLOSE
        say(f"{ask} by {by}")

    def hand_gone(self, by: str) -> None:
        say(f"{by} is gone")
        ended.set()


with session_keys(Session()):  # type: ignore[arg-type]
    say("listens")
    ended.wait()
