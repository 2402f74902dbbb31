"""Pacing of a hand's commands, with times from the tests."""

from __future__ import annotations

from itertools import pairwise
from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command
from firstcontact.grasp import HandLimits
from firstcontact.grasp._safe import Due, Pacer

LIMITS = HandLimits(speed=0.1, force=5.0, rate=100.0, watchdog=0.3)
SLOW = Command(0.01, 1.0)
GENTLE = Command(0.005, 0.5)

numbers = st.floats(-1e3, 1e3)


@given(numbers, numbers)
def test_commands_are_clipped_to_the_limits(speed: float, force: float) -> None:
    pacer = Pacer(LIMITS, 1.0)
    pacer.offer(Command(speed, force), 0.0)
    due = pacer.due(0.0)
    assert due is not None
    assert due.command is not None
    assert abs(due.command.speed) <= LIMITS.speed
    assert 0 <= due.command.force <= LIMITS.force
    inside = abs(speed) <= LIMITS.speed and 0 <= force <= LIMITS.force
    assert pacer.counts.clipped == (not inside)
    if inside:
        assert due.command == Command(speed, force)


@pytest.mark.parametrize("command", [Command(nan, 1.0), Command(0.1, inf), Command(-inf, 1.0)])
def test_commands_that_are_not_finite_are_refused(command: Command) -> None:
    pacer = Pacer(LIMITS, 1.0)
    with pytest.raises(ValueError, match="m/s"):
        pacer.offer(command, 0.0)
    assert pacer.due(0.0) is None


@given(st.lists(st.tuples(st.floats(0, 0.05), st.floats(0, 0.1)), min_size=1, max_size=60))
def test_the_rate_holds_and_the_last_command_arrives(steps: list[tuple[float, float]]) -> None:
    pacer = Pacer(LIMITS, inf)
    now, sent = 0.0, []
    for wait, speed in steps:
        now += wait
        pacer.offer(Command(speed, 1.0), now)
        if (due := pacer.due(now)) is not None:
            sent.append((now, due.command))
    while pacer.counts.sent + pacer.counts.superseded < len(steps):
        now = pacer.next_time()
        due = pacer.due(now)
        assert due is not None
        sent.append((now, due.command))
    assert sent[-1][1] == Command(steps[-1][1], 1.0)
    assert all(b[0] - a[0] >= 0.999 / LIMITS.rate for a, b in pairwise(sent))
    assert pacer.counts.sent + pacer.counts.superseded == len(steps)


def test_newer_command_replaces_a_waiting_one() -> None:
    pacer = Pacer(LIMITS, 1.0)
    pacer.offer(SLOW, 0.0)
    assert pacer.due(0.0) == Due(SLOW)
    pacer.offer(SLOW, 0.002)
    pacer.offer(GENTLE, 0.004)
    assert pacer.due(0.005) is None
    assert pacer.due(pacer.next_time()) == Due(GENTLE)
    assert (pacer.counts.sent, pacer.counts.superseded) == (2, 1)


def test_last_command_is_repeated_before_the_hands_watchdog_acts() -> None:
    limits = HandLimits(0.1, 5.0, 100.0, watchdog=0.75)
    pacer = Pacer(limits, 1.0)
    pacer.offer(SLOW, 0.0)
    now = 0.0
    while (due := pacer.due(now)) == Due(SLOW):
        sent, now = now, pacer.next_time()
        assert now - sent < limits.watchdog
    assert due == Due(None), "silence must end in a release"
    assert now == 1.0
    assert pacer.counts.repeated == 3
    assert pacer.next_time() == inf, "a released hand needs no further action"


def test_alive_postpones_the_release() -> None:
    pacer = Pacer(HandLimits(0.1, 5.0, 100.0, inf), 1.0)
    pacer.offer(SLOW, 0.0)
    pacer.due(0.0)
    pacer.alive(0.9)
    assert pacer.due(1.5) is None
    assert pacer.due(1.9) == Due(None)
    assert pacer.counts.released == 1
