"""A hand in a process of its own: told there, let go there, and the process ends."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from hands import PATIENCE, refused

from firstcontact.core import Command, InputError
from firstcontact.grasp._separate import MUTE, SeparateHand

CLOSE = Command(0.02, 2.0)
#: A hand that writes down what it is told, in a file; "fail" there makes it fail.
MODULE = """
from math import inf
from firstcontact.core._errors import InputError
from firstcontact.grasp._hand import Begins, HandError, HandLimits

class FileHand:
    name = "file"
    begins = Begins.US
    limits = HandLimits(speed=0.1, force=5.0, rate=100.0, watchdog=inf)

    def __init__(self, port):
        self.file = port

    def note(self, text):
        with open(self.file, "a") as file:
            file.write(text + "\\n")

    def send(self, command):
        if command.force == 4.0:
            raise HandError("the cable is out")
        self.note(f"{command.speed} {command.force}")

    def release(self):
        self.note("release")

    def close(self):
        self.note("close")

    def __enter__(self):
        if self.file.endswith("nowhere"):
            raise InputError("nowhere is no port")
        if self.file.endswith("crash"):
            raise ZeroDivisionError
        print("to whoever reads standard output")
        return self

    def __exit__(self, *error):
        self.close()
"""


@pytest.fixture(autouse=True)
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The hand's module, importable here and in other processes."""
    (tmp_path / "file_hand.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    monkeypatch.setenv("PYTHONPATH", path)
    yield
    sys.modules.pop("file_hand", None)


def made(told: Path, silence: float = PATIENCE) -> SeparateHand:
    """A hand that writes into this file."""
    from file_hand import FileHand

    return SeparateHand(FileHand, str(told), silence)


def wait_for(told: Path, *last: str) -> list[str]:
    """Until the last lines of a file are these."""
    tick = threading.Event()
    lines: list[str] = []
    for _ in range(int(PATIENCE / 0.02)):
        lines = told.read_text().splitlines() if told.exists() else []
        if lines[-len(last) :] == list(last):
            return lines
        tick.wait(0.02)
    pytest.fail(f"{lines}")


def process_of(hand: SeparateHand) -> int:
    """The number of its process."""
    assert hand._child is not None
    return hand._child.pid


@contextmanager
def watched(pid: int) -> Iterator[int]:
    """A descriptor that becomes readable when a process ends."""
    descriptor = os.pidfd_open(pid)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def ends(descriptor: int) -> bool:
    return bool(select.select([descriptor], [], [], PATIENCE)[0])


def test_orders_come_in_order_and_the_end_releases(tmp_path: Path) -> None:
    told = tmp_path / "told"
    with made(told) as hand, watched(process_of(hand)) as process:
        hand.send(CLOSE)
        hand.send(Command(0.0, 1.5))
        hand.release()
        hand.send(CLOSE)
        hand.close()
        assert ends(process)
    assert told.read_text().splitlines() == ["0.02 2.0", "0.0 1.5", "release", "0.02 2.0", "close"]


def test_a_pipe_that_is_silent_releases(tmp_path: Path) -> None:
    told = tmp_path / "told"
    with made(told, silence=0.2) as hand:
        assert hand.limits.watchdog == 0.2, "so often it must be told"
        hand.send(CLOSE)
        wait_for(told, "0.02 2.0", "release")
        hand.send(CLOSE)
        wait_for(told, "release", "0.02 2.0", "release")


def test_a_hand_that_fails_is_told_with_its_own_words(tmp_path: Path) -> None:
    with made(tmp_path / "told") as hand:
        hand.send(Command(0.0, 4.0))
        assert refused(hand, CLOSE) == "the cable is out"


def test_a_process_that_is_killed_or_stopped_is_noticed(tmp_path: Path) -> None:
    with made(tmp_path / "told") as hand:
        os.kill(process_of(hand), signal.SIGKILL)
        assert "process of the hand 'file'" in refused(hand, CLOSE)
        hand.release()
    with made(tmp_path / "told") as hand, watched(process_of(hand)) as process:
        os.kill(process_of(hand), signal.SIGSTOP)
        assert "does not answer" in refused(hand, CLOSE)
        hand.release()
        hand.close()
        assert ends(process), "it was killed, since it did not end"
    assert MUTE <= 1.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP, signal.SIGQUIT])
def test_signals_to_the_program_are_not_for_it(number: signal.Signals, tmp_path: Path) -> None:
    told = tmp_path / "told"
    with made(told) as hand:
        os.kill(process_of(hand), number)
        hand.send(CLOSE)
        wait_for(told, "0.02 2.0")


def test_terminated_it_lets_go(tmp_path: Path) -> None:
    told = tmp_path / "told"
    with made(told) as hand, watched(process_of(hand)) as process:
        os.kill(process_of(hand), signal.SIGTERM)
        assert ends(process)
        wait_for(told, "close")


@pytest.mark.parametrize(
    ("port", "words"), [("nowhere", "nowhere is no port"), ("crash", "ZeroDivisionError")]
)
def test_a_hand_that_cannot_be_opened_is_refused(port: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=words):
        made(tmp_path / port).__enter__()


PARENT = """
import sys
from file_hand import FileHand
from firstcontact.core import Command
from firstcontact.grasp._separate import SeparateHand
with SeparateHand(FileHand, sys.argv[1], 60.0) as hand:
    hand.send(Command(0.02, 2.0))
    print(hand._child.pid, flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("stopped", [False, True])
def test_it_lets_go_and_ends_when_the_program_is_killed(tmp_path: Path, stopped: bool) -> None:
    told = tmp_path / "told"
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", PARENT, told], stdin=pipe, stdout=pipe) as program:
        assert program.stdout is not None
        pid = int(program.stdout.readline())
        wait_for(told, "0.02 2.0")
        with watched(pid) as process:
            if stopped:
                os.kill(pid, signal.SIGSTOP)
            program.kill()
            assert ends(process)
    assert told.read_text().splitlines()[-1] == "close"
