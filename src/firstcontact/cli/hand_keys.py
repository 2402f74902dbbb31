"""Closing and opening the hand by keys of the terminal, or by lines on standard input."""

from __future__ import annotations

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Literal

from firstcontact.core import InputError
from firstcontact.core.records import read_record
from firstcontact.live.hand_requests import Ask
from firstcontact.live.session import LiveSession

#: Keys that close the hand; these and no others, so that what is hit in haste opens.
CLOSES = b"cC"
#: Longest line, bytes.
LONGEST = 4096
#: How often a terminal is looked at that is another program's meanwhile, s.
AGAIN = 0.5


@dataclass(frozen=True, slots=True)
class Wish:
    """A line of JSON."""

    do: Literal["close", "open"]


@contextmanager
def hand_keys(session: LiveSession) -> Iterator[None]:
    """Let whoever has standard input close and open the hand of a session.

    On a terminal the key C closes and any other opens; a terminal's keys are left to another
    program that is in its foreground. Otherwise lines are read: ``close``, ``open``, or JSON as
    ``{"do": "close"}``. Standard input that ends opens what it had closed.
    """
    if sys.stdin is None or sys.stdin.closed or not session.hand_asks():
        yield
        return
    number = sys.stdin.fileno()
    ending, end = os.pipe()
    before = _keys_at_once(number)
    by = "keyboard" if before else "standard input"
    _say("keys: C closes the hand, any other key opens it" if before else "")
    thread = threading.Thread(
        target=_listen, args=(session, number, ending, bool(before), by), name="keys", daemon=True
    )
    thread.start()
    try:
        yield
    finally:
        os.close(end)
        thread.join()
        os.close(ending)
        if before:
            with suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(number, termios.TCSADRAIN, before)


def _keys_at_once(number: int) -> list[Any] | None:
    """Have a terminal give each key as it is hit; how it was, None where there is none."""
    if not (os.isatty(number) and _ours(number)):
        return None
    try:
        before = termios.tcgetattr(number)
        tty.setcbreak(number, termios.TCSADRAIN)
    except termios.error:
        return None
    return before


def _ours(number: int) -> bool:
    """Whether this program is in the terminal's foreground: otherwise reading would stop it."""
    try:
        return os.tcgetpgrp(number) == os.getpgrp()
    except OSError:
        return False


def _listen(session: LiveSession, number: int, ending: int, keys: bool, by: str) -> None:
    part = b""
    terminal = os.isatty(number)
    while True:
        if terminal and not _ours(number):
            if select.select([ending], [], [], AGAIN)[0]:
                return
            continue
        if ending in select.select([number, ending], [], [])[0]:
            return
        try:
            data = os.read(number, LONGEST)
        except OSError:
            data = b""
        if not data:
            session.hand_gone(by)
            return
        if keys:
            # Several at once are no more than the last of them, unless one of them opens.
            _ask(session, Ask.CLOSE if all(key in CLOSES for key in data) else Ask.OPEN, by)
            continue
        *lines, part = (part + data).split(b"\n")
        for line in lines:
            _line(session, line.strip(), by)
        part = part[: LONGEST + 1]  # of a line that is too long its beginning will do


def _line(session: LiveSession, line: bytes, by: str) -> None:
    word = line.lower()
    if len(line) > LONGEST:
        word = line = b"..."
    if line.startswith(b"{"):
        try:
            word = read_record(line, Wish, "This line", 'use {"do": "open"}', LONGEST).do.encode()
        except InputError as error:
            _say(str(error))
            return
    if word not in (b"close", b"open"):
        _say(f"the line {line.decode('utf-8', 'replace')!r} is no request: use close or open")
        return
    _ask(session, Ask(word.decode()), by)


def _ask(session: LiveSession, ask: Ask, by: str) -> None:
    try:
        session.ask_hand(ask, by)
    except InputError as error:
        _say(str(error))


def _say(line: str) -> None:
    if line:
        print(line, file=sys.stderr, flush=True)
