"""Pacing of a hand's commands, with times from the tests."""

from itertools import pairwise
from math import inf

from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command
from firstcontact.grasp import HandLimits
from firstcontact.grasp.pacing import Due, Pacer

LIMITS = HandLimits(speed=0.1, force=5.0, rate=100.0, watchdog=0.3)
SLOW = Command(0.01, 1.0)


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
        sent.append((now, due.command))
    assert sent[-1][1] == Command(steps[-1][1], 1.0)
    assert all(b[0] - a[0] >= 0.999 / LIMITS.rate for a, b in pairwise(sent))
    assert pacer.counts.sent + pacer.counts.superseded == len(steps)


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


def test_hand_whose_own_watchdog_acted_gets_no_old_command() -> None:
    pacer = Pacer(LIMITS, 1.0)
    pacer.offer(SLOW, 0.0)
    assert pacer.due(0.0) == Due(SLOW)
    pacer.alive(0.5)
    assert pacer.due(0.5) == Due(None)
    assert pacer.silenced


def test_alive_postpones_the_release() -> None:
    pacer = Pacer(HandLimits(0.1, 5.0, 100.0, inf), 1.0)
    pacer.offer(SLOW, 0.0)
    pacer.due(0.0)
    pacer.alive(0.9)
    assert pacer.due(1.5) is None
    assert pacer.due(1.9) == Due(None)
    assert pacer.counts.released == 1
