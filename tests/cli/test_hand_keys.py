"""Keys of a terminal and lines on standard input close and open the hand."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
import termios
from pathlib import Path

PROGRAM = [sys.executable, str(Path(__file__).with_name("keys_program.py"))]
PATIENCE = 60.0


def said(lines: bytes) -> tuple[list[str], str]:
    """What the program says of these lines, and of them to a person."""
    done = subprocess.run(PROGRAM, input=lines, capture_output=True, timeout=PATIENCE, check=True)
    asked = [line for line in done.stdout.decode().splitlines() if line != "listens"]
    return asked, done.stderr.decode()


def test_lines_ask_and_their_end_is_told() -> None:
    asked, told = said(b'close\nOPEN \n{"do": "close"}\n{"do":"open"}\n')
    by = "by standard input"
    assert asked == [f"close {by}", f"open {by}"] * 2 + ["standard input is gone"]
    assert told == ""


def test_lines_that_are_no_requests_are_told_and_the_next_is_heard() -> None:
    wrong = (b"shut", b"\xff\xfe", b"", b'{"do": "hold"}', b'{"do"', b"x" * 9000)
    asked, told = said(b"\n".join(wrong) + b"\nopen\n")
    assert asked == ["open by standard input", "standard input is gone"]
    assert told.count("\n") == len(wrong)
    assert "use close or open" in told


def test_a_key_closes_and_any_other_opens_and_the_terminal_is_as_it_was() -> None:
    pid, terminal = pty.fork()
    if pid == 0:
        os.execv(sys.executable, PROGRAM)
    try:
        before = termios.tcgetattr(terminal)
        output = b""

        def until(words: bytes) -> None:
            nonlocal output
            while words not in output:
                output += os.read(terminal, 4096)

        until(b"listens")
        assert b"C closes the hand" in output
        assert termios.tcgetattr(terminal) != before
        for keys, words in (
            (b"c", b"close by keyboard"),
            (b" ", b"open by keyboard"),
            (b"C", b"close by keyboard"),
            (b"cx", b"open by keyboard"),  # what is hit in haste opens
            (b"c", b"close by keyboard"),
            (b"c", b"again by keyboard"),
        ):
            output = b""
            os.write(terminal, keys)
            until(words)
        assert os.waitpid(pid, 0)[1] == 0
        assert termios.tcgetattr(terminal) == before
    finally:
        os.close(terminal)
