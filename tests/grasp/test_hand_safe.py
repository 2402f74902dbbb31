"""A hand is released on every way out."""

from __future__ import annotations

import select
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from math import inf, nan
from pathlib import Path

import pytest
from hands import PATIENCE, HeardHand

from firstcontact.core import Command
from firstcontact.grasp import HandError, HandLimits, SafeHand
from firstcontact.grasp._leaving import ENDING

PROGRAM = Path(__file__).with_name("hand_program.py")
SLOW_PROGRAM = Path(__file__).with_name("slow_hand_program.py")
SLOW = Command(0.01, 1.0)
HOLD = Command(0.0, 1.0)


def test_commands_reach_the_hand_in_order_and_the_last_is_never_lost() -> None:
    heard = HeardHand(HandLimits(speed=1000.0, force=5.0, rate=50.0, watchdog=inf))
    with SafeHand(heard, silence=PATIENCE) as hand:
        for number in range(200):
            hand.send(Command(float(number), 1.0))
        heard.wait(lambda told: told[-1:] == [Command(199.0, 1.0)])
        counts = hand.counts
        assert counts.sent + counts.superseded == 200
    speeds = [x.speed for x in heard.told if isinstance(x, Command)]
    assert speeds == sorted(speeds)
    assert len(speeds) == counts.sent
    assert heard.told[-2:] == ["release", "close"]


def test_an_exception_releases_and_goes_on() -> None:
    heard = HeardHand()

    def use() -> None:
        with SafeHand(heard) as hand:
            hand.send(SLOW)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        use()
    assert heard.told == [SLOW, "release", "close"]


def test_a_silent_program_loses_the_hand_and_may_come_back() -> None:
    heard = HeardHand()
    with SafeHand(heard, silence=0.1) as hand:
        hand.send(SLOW)
        heard.wait(lambda told: told == [SLOW, "release"])
        assert hand.counts.released == 1
        hand.send(HOLD)
        heard.wait(lambda told: HOLD in told)


def test_a_program_that_says_that_it_lives_keeps_the_hand() -> None:
    now = [0.0]
    heard = HeardHand()
    with SafeHand(heard, silence=1.0, clock=lambda: now[0]) as hand:
        hand.send(SLOW)
        for _ in range(10):
            now[0] += 0.9
            hand.alive()
        hand.send(HOLD)
        assert heard.told == [SLOW, HOLD]


def test_the_last_command_is_repeated() -> None:
    heard = HeardHand(HandLimits(speed=0.1, force=5.0, rate=1000.0, watchdog=0.03))
    with SafeHand(heard, silence=PATIENCE) as hand:
        hand.send(SLOW)
        heard.wait(lambda told: told.count(SLOW) >= 4)
        assert hand.counts.repeated >= 3
        assert hand.counts.sent == 1


def test_a_command_that_is_no_number_releases_and_is_refused() -> None:
    heard = HeardHand()
    with SafeHand(heard) as hand:
        hand.send(SLOW)
        with pytest.raises(HandError, match=r"nan m/s.*released"):
            hand.send(Command(nan, 1.0))
        assert heard.told == [SLOW, "release"]
        hand.send(HOLD)
        heard.wait(lambda told: HOLD in told)


def test_a_hand_that_fails_is_released_and_the_program_is_told() -> None:
    heard = HeardHand()
    with SafeHand(heard) as hand:
        heard.error = OSError("the cable is out")
        with pytest.raises(HandError, match="the cable is out"):
            hand.send(SLOW)
        assert heard.told == ["release"]
        heard.error = None
        with pytest.raises(HandError, match="the cable is out"):
            hand.alive()
    assert heard.told == ["release", "release", "close"]


def test_a_hand_that_fails_in_the_background_tells_at_the_next_word() -> None:
    heard = HeardHand(HandLimits(speed=0.1, force=5.0, rate=1000.0, watchdog=0.03))
    with SafeHand(heard, silence=PATIENCE) as hand:
        hand.send(SLOW)
        heard.error = OSError("the cable is out")
        heard.wait(lambda told: "release" in told)
        assert "OSError: the cable is out" in str(hand.failure)
        with pytest.raises(HandError, match="the cable is out"):
            hand.send(SLOW)


def test_closing_twice_and_commands_outside_of_the_block() -> None:
    hand = SafeHand(HeardHand())
    with pytest.raises(HandError, match="not open"):
        hand.send(SLOW)
    with hand:
        hand.send(SLOW)
        hand.close()
        hand.close()
        with pytest.raises(HandError, match="not open"):
            hand.send(SLOW)
    with pytest.raises(HandError, match="once"):
        hand.__enter__()


def test_signals_are_as_they_were_afterwards() -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, *ENDING)]
    with SafeHand(HeardHand()):
        assert all(signal.getsignal(number) is not signal.SIG_DFL for number in ENDING)
    assert [signal.getsignal(number) for number in (signal.SIGINT, *ENDING)] == before


class DisturbedHand(HeardHand):
    """Signals come while it is being closed."""

    def close(self) -> None:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
        super().close()


def test_signals_wait_until_the_hand_is_let_go() -> None:
    heard = DisturbedHand()
    with pytest.raises(KeyboardInterrupt), SafeHand(heard) as hand:
        hand.send(SLOW)
    assert heard.told == [SLOW, "release", "close"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_releases_even_where_the_program_goes_on() -> None:
    heard = HeardHand()
    with SafeHand(heard, silence=PATIENCE) as hand:
        for times in (1, 2):  # it goes on after the first: the next signal is a first again
            hand.send(SLOW)
            heard.wait(lambda told: told[-1:] == [SLOW])
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            heard.wait(lambda told, n=times: told == [SLOW, "release"] * n)  # type: ignore[misc]


def test_a_hand_that_is_interrupted_while_it_opens_is_closed() -> None:
    class Interrupted(HeardHand):
        def __enter__(self) -> Interrupted:
            signal.raise_signal(signal.SIGINT)
            return self

    heard = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        SafeHand(heard).__enter__()
    assert heard.told == ["close"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@contextmanager
def slow_program() -> Iterator[subprocess.Popen[str]]:
    """One that has closed a slow hand, and has been asked to stop."""
    with subprocess.Popen(
        [sys.executable, SLOW_PROGRAM],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as program:
        try:
            assert program.stdout is not None
            assert program.stdout.readline() == "closing\n"
            program.send_signal(signal.SIGINT)
            yield program
        finally:
            program.kill()


def lets_go(program: subprocess.Popen[str]) -> None:
    """It is told to let go, says so, and ends as one that was interrupted."""
    said, _ = program.communicate("go\n", timeout=PATIENCE)
    assert said == "let go\n"
    assert program.returncode == -signal.SIGINT


def test_more_signals_do_not_disturb_the_letting_go() -> None:
    with slow_program() as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "letting go\n"
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            program.send_signal(number)
        lets_go(program)


def test_signals_that_never_stop_do_not_keep_it_from_letting_go() -> None:
    """They hit the way out of the block, too, before anything of the hand is called."""
    with slow_program() as program:
        assert program.stdout is not None
        while not select.select([program.stdout], [], [], 0.0002)[0]:
            program.send_signal(signal.SIGINT)
        assert program.stdout.readline() == "letting go\n"
        lets_go(program)


def test_a_handler_of_the_program_stays() -> None:
    def mine(number: int, frame: object) -> None:
        """Not called."""

    before = signal.signal(signal.SIGTERM, mine)
    try:
        with SafeHand(HeardHand()):
            assert signal.getsignal(signal.SIGTERM) is mine
        assert signal.getsignal(signal.SIGTERM) is mine
    finally:
        signal.signal(signal.SIGTERM, before)


def test_a_hand_can_be_used_from_another_thread() -> None:
    heard = HeardHand()

    def use() -> None:
        with SafeHand(heard) as hand:
            hand.send(SLOW)

    thread = threading.Thread(target=use)
    thread.start()
    thread.join(PATIENCE)
    assert heard.told == [SLOW, "release", "close"]


@pytest.mark.parametrize(
    ("then", "number", "code"),
    [
        ("wait", signal.SIGINT, -signal.SIGINT),
        ("wait", signal.SIGTERM, 128 + signal.SIGTERM),
        ("wait", signal.SIGHUP, 128 + signal.SIGHUP),
        ("wait", signal.SIGQUIT, 128 + signal.SIGQUIT),
        ("hang", signal.SIGTERM, 128 + signal.SIGTERM),
        ("raise", None, 1),
        ("exit", None, 0),
    ],
)
def test_a_program_that_ends_releases(then: str, number: int | None, code: int) -> None:
    program = subprocess.Popen(
        [sys.executable, PROGRAM, "print", "-", then],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert program.stdout is not None
    assert program.stdout.readline() == "closing\n"
    if number is not None:
        program.send_signal(number)
    _, orders = program.communicate(timeout=PATIENCE)
    assert program.returncode == code, orders
    told = [line for line in orders.splitlines() if line.startswith("hand ")]
    assert "close at 20.0 mm/s, at most 2.00 N" in told[0]
    assert told[-1].endswith("release")
