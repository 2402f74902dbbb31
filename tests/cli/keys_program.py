"""Says what is asked of a hand from standard input, as ``live`` listens to it."""

from __future__ import annotations

import threading

from firstcontact.cli.hand_keys import hand_keys
from firstcontact.core import InputError
from firstcontact.live.hand_requests import Ask

ended = threading.Event()


class Session:
    """Says what it is asked."""

    closed = False

    def hand_asks(self) -> tuple[Ask, ...]:
        return tuple(Ask)

    def ask_hand(self, ask: Ask, by: str) -> None:
        if ask is Ask.CLOSE and self.closed:
            print(f"again by {by}", flush=True)
            ended.set()
            raise InputError("it is closed already")
        self.closed = ask is Ask.CLOSE
        print(f"{ask} by {by}", flush=True)

    def hand_gone(self, by: str) -> None:
        print(f"{by} is gone", flush=True)
        ended.set()


with hand_keys(Session()):  # type: ignore[arg-type]
    print("listens", flush=True)
    ended.wait()
