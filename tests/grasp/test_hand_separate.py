"""Hand in a separate process: its orders, its release and the end of the process."""

import os
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from pathlib import Path

import pytest
from hands import PATIENCE, refused

from firstcontact.core import Command, InputError
from firstcontact.grasp import HandError, SafeHand
from firstcontact.grasp.registry import make_hand
from firstcontact.grasp.separate import MUTE, PROMPT, SeparateHand
from processes import until

CLOSE = Command(0.02, 2.0)
#: Module with a hand that writes its orders into a file. 4 N make it fail, 3 N block.
MODULE = """
import threading
from collections import deque
from math import inf
from firstcontact.core._errors import InputError
from firstcontact.grasp.hand import Begins, Hand, HandError, HandLimits

class FileHand(Hand):
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
        if command.force == 3.0:
            threading.Event().wait()
        self.note(f"{command.speed} {command.force}")

    def positions(self):
        return deque((1.0 + 0.01 * k, 0.02 + 1e-3 * k) for k in range(200))

    def release(self):
        if self.file.endswith("slow"):
            threading.Event().wait(1.3)
        self.note("release")
        if self.file.endswith("stuck"):
            threading.Event().wait()

    def close(self):
        self.note("close")

    def __enter__(self):
        if self.file.endswith("nowhere"):
            raise InputError("nowhere is no port")
        if self.file.endswith("crash"):
            raise ZeroDivisionError
        print("a line on standard output")
        return self

    def __exit__(self, *error):
        self.close()
"""


@pytest.fixture(autouse=True)
def module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Write the hand's module, importable here and in other processes."""
    (tmp_path / "file_hand.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    monkeypatch.setenv("PYTHONPATH", path)
    yield
    sys.modules.pop("file_hand", None)


def file_hand(log: Path, silence: float = PATIENCE) -> SeparateHand:
    """Return a hand that writes into this file."""
    from file_hand import FileHand

    return SeparateHand(FileHand, str(log), silence)


def await_lines(log: Path, *last: str) -> list[str]:
    """Wait until the last lines of a file are these, and return all lines.

    Equal lines in a row count as one: a hand without orders is released again and again.
    """

    def lines() -> list[str]:
        text = log.read_text() if log.exists() else ""
        return [line for line, _ in groupby(text.splitlines())]

    until(lambda: lines()[-len(last) :] == list(last))
    return lines()


@contextmanager
def watched(pid: int) -> Iterator[int]:
    """Open a descriptor that becomes readable when the process ends."""
    descriptor = os.pidfd_open(pid)
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def ends(descriptor: int) -> bool:
    return bool(select.select([descriptor], [], [], PATIENCE)[0])


def test_its_process_tells_the_last_positions(tmp_path: Path) -> None:
    with SafeHand(file_hand(tmp_path / "log"), silence=PATIENCE) as hand:
        for _ in range(int(PATIENCE / PROMPT)):  # a busy process may be late
            if (speed := hand.closing_speed(0.0, 3.0)) is not None:
                break
        assert hand.closing_speed(0.0, 1.0) is None
    assert speed.speed == pytest.approx(0.1)


def test_orders_keep_their_order_and_the_end_releases(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with file_hand(log) as hand, watched(hand.pid) as process:
        hand.send(CLOSE)
        hand.send(Command(0.0, 1.5))
        hand.release()
        hand.send(CLOSE)
        hand.close()
        assert ends(process)
    assert log.read_text().splitlines() == ["0.02 2.0", "0.0 1.5", "release", "0.02 2.0", "close"]


def test_silent_pipe_releases(tmp_path: Path) -> None:
    log = tmp_path / "log"
    with file_hand(log, silence=0.2) as hand:
        assert hand.limits.watchdog == 0.2, "the silence limits the watchdog"
        hand.send(CLOSE)
        await_lines(log, "0.02 2.0", "release")
        hand.send(CLOSE)
        await_lines(log, "release", "0.02 2.0", "release")


def test_failure_of_the_hand_reaches_the_program(tmp_path: Path) -> None:
    with file_hand(tmp_path / "log") as hand:
        hand.send(Command(0.0, 4.0))
        assert refused(hand, CLOSE) == "the cable is out"


def test_driver_that_blocks_is_interrupted_and_opens_the_hand(tmp_path: Path) -> None:
    from file_hand import FileHand

    made = make_hand(FileHand, str(tmp_path / "log"))  # separate by default
    assert isinstance(made, SeparateHand)
    with made as hand:
        hand.send(Command(0.0, 3.0))
        assert "does not answer" in refused(hand, CLOSE)
    assert (tmp_path / "log").read_text().splitlines() == ["close"]


def test_release_that_blocks_is_interrupted_without_another_order(tmp_path: Path) -> None:
    log = tmp_path / "stuck"
    with SafeHand(file_hand(log), silence=PATIENCE) as hand:
        hand.release()
        until(lambda: hand.failure is not None)
        assert "does not answer" in str(hand.failure)
        await_lines(log, "release", "close")


def test_release_may_take_longer_than_other_orders(tmp_path: Path) -> None:
    log = tmp_path / "slow"
    with SafeHand(file_hand(log), silence=PATIENCE) as hand:
        hand.release()
        hand.send(CLOSE)
        await_lines(log, "release", "0.02 2.0")
        assert hand.failure is None


def test_killed_or_suspended_process_is_noticed(tmp_path: Path) -> None:
    with file_hand(tmp_path / "log") as hand:
        os.kill(hand.pid, signal.SIGKILL)
        assert "process of the hand 'file'" in refused(hand, CLOSE)
        hand.release()
        with pytest.raises(HandError, match="nothing confirms"):
            hand.close()
    with file_hand(tmp_path / "log") as hand, watched(hand.pid) as process:
        os.kill(hand.pid, signal.SIGSTOP)
        assert "does not answer" in refused(hand, CLOSE)
        hand.release()
        with pytest.raises(HandError, match="nothing confirms"):
            hand.close()
        assert ends(process), "a suspended process must be killed"
    assert MUTE <= 1.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP, signal.SIGQUIT])
def test_process_ignores_signals_to_the_program(number: signal.Signals, tmp_path: Path) -> None:
    log = tmp_path / "log"
    with file_hand(log) as hand:
        os.kill(hand.pid, number)
        hand.send(CLOSE)
        await_lines(log, "0.02 2.0")


@pytest.mark.parametrize(
    ("port", "reason"), [("nowhere", "nowhere is no port"), ("crash", "ZeroDivisionError")]
)
def test_hand_that_cannot_open_is_refused(port: str, reason: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=reason):
        file_hand(tmp_path / port).__enter__()


PARENT = """
import sys
from file_hand import FileHand
from firstcontact.core import Command
from firstcontact.grasp.separate import SeparateHand
with SeparateHand(FileHand, sys.argv[1], 60.0) as hand:
    hand.send(Command(0.02, 2.0))
    print(hand._child.pid, flush=True)
    sys.stdin.read()
"""


@pytest.mark.parametrize("stopped", [False, True])
def test_process_releases_and_ends_after_the_program(tmp_path: Path, stopped: bool) -> None:
    log = tmp_path / "log"
    pipe = subprocess.PIPE
    with subprocess.Popen([sys.executable, "-c", PARENT, log], stdin=pipe, stdout=pipe) as program:
        pid = int(program.stdout.readline())
        await_lines(log, "0.02 2.0")
        with watched(pid) as process:
            if stopped:
                os.kill(pid, signal.SIGSTOP)
            program.kill()
            assert ends(process)
    assert log.read_text().splitlines()[-1] == "close"
