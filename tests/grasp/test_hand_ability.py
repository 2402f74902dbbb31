"""Ability Hand: its package's simulated hand, and an emulated one on a pseudo terminal."""

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise
from math import degrees
from pathlib import Path

import pytest
from hands import PATIENCE, refused

from emulated_ability import EmulatedAbility
from firstcontact.core import Command, InputError
from firstcontact.device.ports import PseudoTerminal
from firstcontact.grasp import SafeHand, ability
from firstcontact.grasp.ability import CLOSED, INDEX, LEVERS, NEARLY_OPEN, OPEN, THUMB, AbilityHand
from firstcontact.grasp.ability_package import SIMULATED
from processes import until

PROGRAM = Path(__file__).with_name("hand_program.py")
CLOSE = Command(0.05, 2.0)
LOST = ability.LOST


@pytest.fixture(autouse=True)
def _is_patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the hand wait long for an answer, because a busy machine may delay it."""
    monkeypatch.setattr(ability, "LOST", PATIENCE / 2)


@pytest.fixture
def lose_soon(_is_patient: None, monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Return a function after whose call a hand is lost as soon as for users."""
    return lambda: monkeypatch.setattr(ability, "LOST", LOST)


@pytest.fixture
def port(tmp_path: Path) -> Path:
    return tmp_path / "ttyHand"


def safe_hand(port: Path) -> SafeHand:
    """Return a hand on this port that tolerates a slow program."""
    return SafeHand(AbilityHand(str(port)), silence=PATIENCE)


def is_closing(emulated: EmulatedAbility) -> bool:
    """Return True if finger and thumb have moved away from open."""
    return min(emulated.targets[-1][INDEX], emulated.targets[-1][THUMB]) > OPEN + 8


def open_then_close(emulated: EmulatedAbility, hand: SafeHand) -> None:
    """Wait until the hand is open, and start to close it."""
    emulated.wait(lambda e: e.open)

    def closing() -> bool:
        hand.send(CLOSE)  # a hand that has failed says why
        return is_closing(emulated)

    until(closing)


def test_the_simulated_hand_of_the_package_closes_stops_and_opens() -> None:
    ability = AbilityHand(SIMULATED)

    def is_beyond(flexion: float, sign: int) -> bool:
        hand.alive()
        return ability.felt is not None and sign * (ability.felt.position[0] - flexion) > 0

    with SafeHand(ability, silence=PATIENCE) as hand:
        until(lambda: is_beyond(NEARLY_OPEN, -1))
        hand.send(CLOSE)
        until(lambda: is_beyond(30.0, 1))
        hand.send(Command(0.0, 2.0))
        positions: list[float] = []
        while len(positions) < 2 or positions[-1] != positions[-2]:
            positions.append(ability.felt.position[0])
            threading.Event().wait(0.2)
        assert positions[-1] < CLOSED - 1, "the hand closed fully"
        hand.release()
        until(lambda: is_beyond(NEARLY_OPEN, -1))
        hand.send(CLOSE)
        until(lambda: is_beyond(20.0, 1))
        times, travels, _ = zip(*ability.positions(), strict=True)
        assert list(times) == sorted(times)
        assert max(travels) > min(travels)
    assert ability.felt.open


def test_hand_closes_in_steps_no_larger_than_commanded(port: Path) -> None:
    with EmulatedAbility(port) as emulated, safe_hand(port) as hand:
        open_then_close(emulated, hand)
        count = len(emulated.targets)
        emulated.wait(lambda e: len(e.targets) > count + 50)
        closing_targets = [t for t in emulated.targets if t[INDEX] > OPEN + 0.1]
        for finger, lever in LEVERS.items():
            steps = [b[finger] - a[finger] for a, b in pairwise(closing_targets)]
            # The longest step is three periods of 10 ms, also when the thread was late.
            assert max(steps) <= degrees(CLOSE.speed / lever) * 0.03 + 0.01
            assert min(steps) >= 0
            assert sum(steps) > 0


def test_hand_reports_the_speed_of_its_rotors_with_each_position(port: Path) -> None:
    with EmulatedAbility(port) as emulated, safe_hand(port) as hand:
        open_then_close(emulated, hand)
        count = len(emulated.targets)
        emulated.wait(lambda e: len(e.targets) > count + 50)
        reports = hand.positions_since(0.0, 0.0)
    times, travels, speeds = map(list, zip(*reports, strict=True))
    moving = [v for v in speeds if v > 0]
    assert len(moving) > 40
    assert max(travels) > travels[0]
    assert len(reports) > (times[-1] - times[0]) * 10, "no faster than a slow encoder"


def test_hand_stops_at_the_force_limit(port: Path) -> None:
    with EmulatedAbility(port, touch_at=25.0) as emulated, safe_hand(port) as hand:
        open_then_close(emulated, hand)
        emulated.wait(lambda e: e.force(INDEX) > 1.5 and e.force(THUMB) > 1.5)
        count = len(emulated.targets)
        emulated.wait(lambda e: len(e.targets) > count + 100)
        # Three steps of 30 ms for the answers still on their way: 4.7 degrees of the thumb.
        assert 1.5 < emulated.hardest < 2.0 + 1.0


def test_hand_opens_when_the_program_is_silent(port: Path) -> None:
    with EmulatedAbility(port) as emulated, AbilityHand(str(port)) as hand:
        emulated.wait(lambda e: e.open)
        tick = threading.Event()
        while not is_closing(emulated):
            hand.send(Command(0.25, 2.0))
            tick.wait(0.02)
        emulated.wait(lambda e: e.open)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL, signal.SIGSTOP])
def test_hand_opens_when_a_signal_ends_or_suspends_the_program(port: Path, number: int) -> None:
    with EmulatedAbility(port) as emulated, started(port) as program:
        emulated.wait(lambda e: bool(e.targets) and is_closing(e))
        program.send_signal(number)
        emulated.wait(lambda e: e.open)


def test_hand_opens_when_the_program_keeps_the_global_lock(port: Path) -> None:
    with EmulatedAbility(port) as emulated, started(port, "hold") as program:
        emulated.wait(lambda e: bool(e.targets) and is_closing(e))
        program.stdin.write("now\n")
        program.stdin.flush()
        emulated.wait(lambda e: e.open)
        # The program is still blocked, and would be for ten minutes.
        assert program.poll() is None
        program.kill()
        emulated.wait(lambda e: not e.controlled)


@contextmanager
def started(port: Path, action: str = "wait") -> Iterator[subprocess.Popen[str]]:
    """Run a program that closes the hand and then does ``action``."""
    # The hand's own process imports a module of this folder.
    path = os.pathsep.join([str(PROGRAM.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    with subprocess.Popen(
        [sys.executable, PROGRAM, "ability", port, action],
        env={**os.environ, "PYTHONPATH": path},
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as program:
        try:
            yield program
        finally:
            program.kill()


def test_hand_that_stops_answering_still_receives_open(
    port: Path, lose_soon: Callable[[], None]
) -> None:
    with EmulatedAbility(port) as emulated, safe_hand(port) as hand:
        open_then_close(emulated, hand)
        lose_soon()
        emulated.mute = True
        assert "stopped answering" in refused(hand, CLOSE)
        emulated.wait(lambda e: e.open)


def test_port_without_a_hand_is_refused(port: Path) -> None:
    terminal = PseudoTerminal(port)
    try:
        with pytest.raises(InputError, match="ttyHand"):
            AbilityHand(str(port)).__enter__()
    finally:
        terminal.unplug()
    assert not sys.stdin.closed


def test_second_program_is_refused(port: Path) -> None:
    with EmulatedAbility(port) as emulated:
        with AbilityHand(str(port)):
            emulated.wait(lambda e: e.open)
            with pytest.raises(InputError, match="ttyHand"):
                AbilityHand(str(port)).__enter__()
        with AbilityHand(str(port)):
            emulated.wait(lambda e: e.controlled)


def test_a_port_is_needed() -> None:
    with pytest.raises(InputError, match="serial port"):
        AbilityHand()


def test_the_package_leaves_no_traces(tmp_path: Path) -> None:
    """The package adds no file, path, module, log handler or output to a new process."""
    code = """
import logging, os, sys
from firstcontact.core import Command
from firstcontact.grasp.ability import AbilityHand
from firstcontact.grasp._safe import SafeHand
path, cwd = list(sys.path), os.getcwd()
with SafeHand(AbilityHand("simulated")) as hand:
    hand.send(Command(0.01, 1.0))
assert sys.path == path and os.getcwd() == cwd
assert "config" not in sys.modules
assert not logging.getLogger().handlers
assert "matplotlib" not in sys.modules
"""
    process = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=PATIENCE,
    )
    assert process.returncode == 0, process.stderr
    assert process.stdout == ""
    assert not list(tmp_path.iterdir())
