"""Terminal keys and input lines that start a new object, and close and open the hand."""

import os
import pty
import subprocess
import sys
import termios
from pathlib import Path

PROGRAM = [sys.executable, str(Path(__file__).with_name("keys_program.py"))]
PATIENCE = 60.0


def send(lines: bytes) -> tuple[list[str], str]:
    """Send lines to the program. Return its requests and its messages."""
    process = subprocess.run(
        PROGRAM, input=lines, capture_output=True, timeout=PATIENCE, check=True
    )
    requests = [line for line in process.stdout.decode().splitlines() if line != "listens"]
    return requests, process.stderr.decode()


def test_lines_send_requests_and_their_end_is_reported() -> None:
    requests, predictions = send(b"close\nOPEN \nnew\n")
    by = "by standard input"
    assert requests == [f"close {by}", f"open {by}", "new object", "standard input is gone"]
    assert predictions == "from the next pinch on: a new object\n"


def test_lines_that_are_no_requests_are_told_and_the_next_is_heard() -> None:
    wrong = (b"shut", b"\xff\xfe", b"", b'{"do": "hold"}', b'{"do"', b"x" * 9000)
    requests, predictions = send(b"\n".join(wrong) + b"\nopen\n")
    assert requests == ["open by standard input", "standard input is gone"]
    assert predictions.count("\n") == len(wrong)
    assert "use close, open or new" in predictions


def test_a_key_closes_and_any_other_opens_and_the_terminal_is_as_it_was() -> None:
    pid, terminal = pty.fork()
    if pid == 0:
        os.execv(sys.executable, PROGRAM)
    try:
        previous = termios.tcgetattr(terminal)
        output = b""

        def until(words: bytes) -> None:
            nonlocal output
            while words not in output:
                output += os.read(terminal, 4096)

        until(b"listens")
        assert b"C closes the hand" in output
        assert termios.tcgetattr(terminal) != previous
        for keys, words in (
            (b"c", b"close by keyboard"),
            (b" ", b"open by keyboard"),
            (b"C", b"close by keyboard"),
            (b"cx", b"open by keyboard"),  # what is hit in haste opens
            (b"c", b"close by keyboard"),
            (b"n", b"new object"),  # as any other key it opens, too
            (b"c", b"close by keyboard"),
            (b"c", b"again by keyboard"),
        ):
            output = b""
            os.write(terminal, keys)
            until(words)
        assert os.waitpid(pid, 0)[1] == 0
        assert termios.tcgetattr(terminal) == previous
    finally:
        os.close(terminal)
