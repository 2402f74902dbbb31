"""Release of a hand, however the program ends."""

from __future__ import annotations

import os
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
from hands import PATIENCE, RecordingHand

from firstcontact.core import Command, InputError
from firstcontact.grasp import HandError, HandLimits, SafeHand, open_hand
from firstcontact.grasp.printing import PrintHand
from firstcontact.testing import check_hand

PROGRAM = Path(__file__).with_name("hand_program.py")
SLOW = Command(0.01, 1.0)
HOLD = Command(0.0, 1.0)


def test_a_hand_that_cannot_start_is_released() -> None:
    recorder = RecordingHand()
    with SafeHand(recorder, silence=PATIENCE) as hand:
        hand.start()
        recorder.error = HandError("stuck")
        with pytest.raises(HandError, match="stuck"):
            hand.start()
        assert recorder.orders == ["start", "release"]


def test_commands_keep_their_order_and_the_last_is_sent() -> None:
    recorder = RecordingHand(HandLimits(speed=1000.0, force=5.0, rate=50.0, watchdog=inf))
    with SafeHand(recorder, silence=PATIENCE) as hand:
        for number in range(200):
            hand.send(Command(float(number), 1.0))
        recorder.wait(lambda orders: orders[-1:] == [Command(199.0, 1.0)])
        counts = hand.counts
        assert counts.sent + counts.superseded == 200
    speeds = [x.speed for x in recorder.orders if isinstance(x, Command)]
    assert speeds == sorted(speeds)
    assert len(speeds) == counts.sent
    assert recorder.orders[-2:] == ["release", "close"]


def test_silent_program_loses_the_hand_until_it_acknowledges_the_release() -> None:
    recorder = RecordingHand()
    with SafeHand(recorder, silence=0.1) as hand:
        hand.send(SLOW)
        recorder.wait(lambda orders: orders == [SLOW, "release"])
        assert hand.counts.released == 1
        with pytest.raises(HandError, match="silent"):
            hand.send(HOLD)
        assert hand.silenced
        hand.release()
        hand.send(HOLD)
        recorder.wait(lambda orders: HOLD in orders)


def test_command_that_is_not_finite_releases_and_is_refused() -> None:
    recorder = RecordingHand()
    with SafeHand(recorder, silence=PATIENCE) as hand:
        hand.send(SLOW)
        with pytest.raises(HandError):
            hand.send(Command(nan, 1.0))
        assert recorder.orders == [SLOW, "release"]
        hand.send(HOLD)
        recorder.wait(lambda orders: HOLD in orders)


def test_failing_hand_is_released_and_raises() -> None:
    recorder = RecordingHand()
    with SafeHand(recorder, silence=PATIENCE) as hand:
        recorder.error = OSError("the cable is out")
        with pytest.raises(HandError, match="the cable is out"):
            hand.send(SLOW)
        assert recorder.orders == ["release"]
        recorder.error = None
        with pytest.raises(HandError, match="the cable is out"):
            hand.alive()
    assert recorder.orders == ["release", "release", "close"]


class StuckHand(RecordingHand):
    """Hand whose first releases fail."""

    def __init__(self, failures: int) -> None:
        super().__init__()
        self._failures = failures

    def release(self) -> None:
        if self._failures:
            self._failures -= 1
            self._record("stuck")
            raise OSError("the hand is stuck")
        super().release()


@pytest.mark.parametrize("failures", [1, 3])
def test_failed_release_of_a_silent_program_is_tried_again(failures: int) -> None:
    recorder = StuckHand(failures)
    with SafeHand(recorder, silence=0.05) as hand:
        hand.send(SLOW)
        recorder.wait(lambda orders: "release" in orders)
        assert recorder.orders == [SLOW, *["stuck"] * failures, "release"]
        with pytest.raises(HandError, match="stuck"):
            hand.send(SLOW)
    assert recorder.orders[-2:] == ["release", "close"]


@pytest.mark.parametrize("silence", [nan, 0.0, -1.0])
def test_silence_that_is_no_time_is_refused(silence: float) -> None:
    with pytest.raises(InputError) as caught:
        open_hand("print", silence=silence)
    assert caught.value.parameter == "silence"


def test_closing_twice_is_allowed_and_commands_outside_the_block_are_refused() -> None:
    hand = SafeHand(RecordingHand())
    with pytest.raises(HandError, match="recording"):
        hand.send(SLOW)
    with hand:
        hand.send(SLOW)
        hand.close()
        hand.close()
        with pytest.raises(HandError, match="recording"):
            hand.send(SLOW)
    with pytest.raises(HandError, match="recording"):
        hand.__enter__()


def test_signal_releases_all_open_hands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("firstcontact.grasp.leaving.INSISTED", inf)
    recorders = [RecordingHand(), RecordingHand()]
    outer, inner = (SafeHand(recorder, silence=PATIENCE) for recorder in recorders)
    with outer, inner:
        outer.send(SLOW)
        inner.send(SLOW)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        for recorder in recorders:
            recorder.wait(lambda orders: orders == [SLOW, "release"])
        inner.close()
        signal.raise_signal(signal.SIGINT)  # a second signal is ignored until the program goes on


class DisturbedHand(RecordingHand):
    """Hand whose ``close`` is interrupted by signals."""

    def close(self) -> None:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGTERM)
        signal.raise_signal(signal.SIGINT)
        super().close()


def test_signals_wait_until_the_hand_is_released() -> None:
    recorder = DisturbedHand()
    with pytest.raises(KeyboardInterrupt), SafeHand(recorder, silence=PATIENCE) as hand:
        hand.send(SLOW)
    assert recorder.orders == [SLOW, "release", "close"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_releases_even_if_the_program_continues() -> None:
    recorder = RecordingHand()
    with SafeHand(recorder, silence=PATIENCE) as hand:
        for times in (1, 2):  # after the program continues, the next signal counts as a first one
            hand.send(SLOW)
            recorder.wait(lambda orders: orders[-1:] == [SLOW])
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
            recorder.wait(lambda orders, n=times: orders == [SLOW, "release"] * n)  # type: ignore[misc]


def test_hand_that_is_interrupted_while_opening_is_closed() -> None:
    class Interrupted(RecordingHand):
        def __enter__(self) -> Interrupted:
            signal.raise_signal(signal.SIGINT)
            return self

    recorder = Interrupted()
    with pytest.raises(KeyboardInterrupt):
        SafeHand(recorder).__enter__()
    assert recorder.orders == ["close"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@contextmanager
def slow_program() -> Iterator[subprocess.Popen[str]]:
    """Run a program that has closed a slow hand, and interrupt it."""
    with subprocess.Popen(
        [sys.executable, PROGRAM, "slow", "-", "wait"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as program:
        try:
            assert program.stdout.readline() == "closing\n"
            program.send_signal(signal.SIGINT)
            yield program
        finally:
            program.kill()


def test_continuous_signals_do_not_prevent_the_release() -> None:
    """Signals also arrive after the end of the block and before the first call of the hand."""
    with slow_program() as program:
        while not select.select([program.stdout], [], [], 0.0002)[0]:
            program.send_signal(signal.SIGINT)
        assert program.stdout.readline() == "letting go\n"
        output, _ = program.communicate("go\n", timeout=PATIENCE)
        assert output == "let go\n"
        assert program.returncode == -signal.SIGINT


def test_handler_of_the_program_stays() -> None:
    def mine(number: int, frame: object) -> None:
        """Ignore the call."""

    previous = signal.signal(signal.SIGTERM, mine)
    try:
        with SafeHand(RecordingHand()):
            assert signal.getsignal(signal.SIGTERM) is mine
        assert signal.getsignal(signal.SIGTERM) is mine
    finally:
        signal.signal(signal.SIGTERM, previous)


def run_program(hand: str, action: str) -> subprocess.Popen[str]:
    """Start a program, and return once it has sent its first command."""
    pipe = subprocess.PIPE
    command = [sys.executable, PROGRAM, hand, "-", action]
    program = subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)
    assert program.stdout.readline() == ("" if hand == "send" else "closing\n")
    return program


@pytest.mark.parametrize("action", ["wait", "alive"])
def test_a_program_that_was_suspended_does_not_close_the_hand_again(action: str) -> None:
    """It ends by an error or after the release, and sends or stays alive until then."""
    program = run_program("print", action)
    program.send_signal(signal.SIGSTOP)
    os.waitid(os.P_PID, program.pid, os.WSTOPPED | os.WNOWAIT)
    threading.Event().wait(1.2)  # longer than the silence
    program.send_signal(signal.SIGCONT)
    _, output = program.communicate(timeout=PATIENCE)
    assert program.returncode == (action == "wait"), output
    orders = [line.split()[3] for line in output.splitlines() if line.startswith("hand ")]
    assert orders == ["close", "release"]


@pytest.mark.parametrize("method", ["send", "release"])
def test_a_driver_that_blocks_does_not_keep_the_program_from_ending(method: str) -> None:
    program = run_program(method, "wait")
    program.send_signal(signal.SIGTERM)
    _, output = program.communicate(timeout=PATIENCE)
    assert program.returncode == 1
    assert "may still hold its object (the hand's code did not return" in output


def test_a_release_may_take_longer_than_other_calls() -> None:
    class Slow(RecordingHand):
        def release(self) -> None:
            threading.Event().wait(1.3)
            super().release()

    recorder = Slow()
    with SafeHand(recorder, silence=PATIENCE) as hand:
        hand.send(SLOW)
        hand.release()
        hand.send(HOLD)
    assert recorder.orders == [SLOW, "release", HOLD, "release", "close"]


def test_a_hand_that_lets_go_in_the_end_is_released() -> None:
    """Its failure is known, but its release was carried out after the call that blocked."""
    let_go = threading.Event()

    class Blocked(RecordingHand):
        def send(self, command: Command) -> None:
            let_go.wait(PATIENCE)

    recorder = Blocked()
    with SafeHand(recorder, silence=PATIENCE) as hand:
        with pytest.raises(HandError, match="did not return"):
            hand.send(SLOW)
        let_go.set()
    assert hand.failure is not None
    assert recorder.orders == ["release", "release", "close"]


def test_reading_a_hand_does_not_wait_for_its_driver() -> None:
    is_sending, goes_on = threading.Event(), threading.Event()

    class Busy(RecordingHand):
        def send(self, command: Command) -> None:
            is_sending.set()
            assert goes_on.wait(PATIENCE)

        def positions_since(self, since: float, host_zero: float) -> list[tuple[float, float]]:
            goes_on.set()
            return [(since, host_zero)]

    with SafeHand(Busy(), silence=PATIENCE) as hand:
        sender = threading.Thread(target=hand.send, args=[SLOW])
        sender.start()
        assert is_sending.wait(PATIENCE)
        assert hand.positions_since(1.0, 2.0) == [(1.0, 2.0)]
        sender.join()
        assert hand.failure is None


POSITIONS: list[object] = [
    [1.0, 2.0], [(0.0, 1e300)], [(nan, 0.0)], [(0.0, nan)], [(0.0, None)], [("a", "b")], None,
    [(0.0, 10**400)], [(0.0, 1.0, 2.0, 3.0)], [(0.0, 1.0), (0.0, 1.0, 2.0)],
]  # fmt: skip


@pytest.mark.parametrize(
    ("method", "reported"), [*(("positions", x) for x in POSITIONS), ("closing_speed", 0.1)]
)
def test_reports_that_are_none_are_refused_with_the_name_of_the_method(
    method: str, reported: object
) -> None:
    kind = type("Odd", (PrintHand,), {method: lambda *_: reported})
    with pytest.raises(HandError, match=method), open_hand(kind()) as hand:
        hand.closing_speed(1.0, 1.0)
    with pytest.raises(AssertionError, match=method):
        check_hand(kind)


def test_positions_may_come_in_any_order() -> None:
    times = [0.99, 0.97, 0.96, 0.98]
    kind = type("Any", (PrintHand,), {"positions": lambda _: [(t, t / 10) for t in times]})
    with open_hand(kind()) as hand:
        assert [at for at, _ in hand.positions_since(0.0, 0.0)] == sorted(times)
        measured = hand.closing_speed(1.0, 1.0)
    assert measured.speed == pytest.approx(0.1)


@pytest.mark.parametrize(
    ("action", "number", "code"),
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
def test_ending_program_releases(action: str, number: int | None, code: int) -> None:
    program = run_program("print", action)
    if number is not None:
        program.send_signal(number)
    _, output = program.communicate(timeout=PATIENCE)
    assert program.returncode == code, output
    orders = [line for line in output.splitlines() if line.startswith("hand ")]
    assert "close at 20.0 mm/s, at most 2.00 N" in orders[0]
    assert orders[-1].endswith("release")
