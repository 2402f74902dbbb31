"""Input from the keyboard or a pipe during a live session: new objects, and hand commands."""

from __future__ import annotations

import os
import select
import sys
import termios
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

from firstcontact.core import InputError
from firstcontact.streaming.events import Ask
from firstcontact.streaming.session import LiveSession

#: Keys that close the hand. Every other key opens it, so that a hasty key opens.
CLOSES = b"cC"
#: Keys that begin a new object. If a hand is driven, they also open it.
NEW = b"nN"
#: Longest line, bytes.
LONGEST_LINE = 4096
#: Time between two checks whether a background program is back in the foreground, s.
AGAIN = 0.5


@contextmanager
def session_keys(session: LiveSession) -> Iterator[None]:
    """Pass keys to a live session within the ``with`` block: N, and those that move the hand."""
    number = _standard_input()
    if number is None or not (session.hand_asks() or (session.uses_shape and os.isatty(number))):
        yield
        return
    ending, end = os.pipe()
    terminal_state = _disable_line_input(number)
    by = "keyboard" if terminal_state else "standard input"
    if terminal_state and session.hand_asks():
        _say("keys: C closes the hand, any other key opens it")
    if terminal_state and session.uses_shape:
        _say("key N: a new object; its pinches are combined until the next N")
    thread = threading.Thread(
        target=_listen,
        args=(session, number, ending, bool(terminal_state), by),
        name="keys",
        daemon=True,
    )
    thread.start()
    try:
        yield
    finally:
        os.close(end)
        thread.join()
        os.close(ending)
        if terminal_state:
            with suppress(termios.error):  # the terminal is gone
                termios.tcsetattr(number, termios.TCSADRAIN, terminal_state)


def _standard_input() -> int | None:
    try:
        return None if sys.stdin is None else sys.stdin.fileno()
    except (OSError, ValueError):
        return None


def _disable_line_input(number: int) -> list[Any] | None:
    """Make a terminal deliver each key at once, without Enter. Return its former settings.

    ``number`` is a file descriptor. If it is not a terminal, or this program is not in the
    foreground, change nothing and return None.
    """
    if not (os.isatty(number) and _is_in_foreground(number)):
        return None
    try:
        terminal_state = termios.tcgetattr(number)
        tty.setcbreak(number, termios.TCSADRAIN)
    except termios.error:
        return None
    return terminal_state


def _is_in_foreground(number: int) -> bool:
    """Return True if this program is in the foreground of a terminal.

    ``number`` is the terminal's file descriptor.
    """
    try:
        return os.tcgetpgrp(number) == os.getpgrp()
    except OSError:
        return False


def _listen(session: LiveSession, number: int, ending: int, keys: bool, by: str) -> None:
    part = b""
    terminal = os.isatty(number)
    while True:
        if terminal and not _is_in_foreground(number):
            if select.select([ending], [], [], AGAIN)[0]:
                return
            continue
        if ending in select.select([number, ending], [], [])[0]:
            return
        try:
            data = os.read(number, LONGEST_LINE)
        except OSError:
            data = b""
        if not data:
            session.hand_gone(by)
            return
        if keys:
            _hit(session, data, by)
            continue
        *lines, part = (part + data).split(b"\n")
        for line in lines:
            _line(session, line.strip(), by)
        part = part[: LONGEST_LINE + 1]  # the beginning of a too long line suffices to refuse it


def _hit(session: LiveSession, keys: bytes, by: str) -> None:
    if session.hand_asks():
        # Several keys at once are one request: to close only if each of them closes.
        _ask(session, Ask.CLOSE if all(key in CLOSES for key in keys) else Ask.OPEN, by)
    if any(key in NEW for key in keys):
        _new(session)


def _new(session: LiveSession) -> None:
    session.new_object()
    _say("from the next pinch on: a new object")


def _line(session: LiveSession, line: bytes, by: str) -> None:
    match line.lower():
        case b"new":
            _new(session)
        case b"close" | b"open" as word:
            _ask(session, Ask(word.decode()), by)
        case _:
            shown = line.decode("utf-8", "replace") if len(line) <= LONGEST_LINE else "..."
            _say(f"the line {shown!r} is not a request: use close, open or new")


def _ask(session: LiveSession, ask: Ask, by: str) -> None:
    try:
        session.ask_hand(ask, by)
    except InputError as error:
        _say(str(error))


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
