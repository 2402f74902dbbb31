"""Grasp loop: calls of the policy and the exact count of missed deadlines."""

import itertools
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import (
    ChannelKind,
    Command,
    Contact,
    Estimate,
    Finger,
    InputError,
    fingertip_layout,
)
from firstcontact.grasp import POLICIES, Grip, HandError, Policy
from firstcontact.grasp.loop import REST, GraspLoop, Taxels
from firstcontact.grasp.policy import Truth
from firstcontact.grasp.registry import make_policy
from firstcontact.testing import make_estimate

RATE = 1000.0
NARROW = make_estimate(50.0, 45.0, 55.0, 0.015)
SHORT = make_estimate(50.0, 10.0, 90.0, 0.003)


def make_loop(name: str, deadline: float | None = None) -> tuple[GraspLoop, list[Command]]:
    sent: list[Command] = []
    policy = make_policy(POLICIES[name], Grip(), Truth(30.0), {})
    loop = GraspLoop(policy, sent.append, RATE, deadline)
    loop.begin()
    return loop, sent


def touch(loop: GraspLoop, sample: int = 100) -> None:
    loop.touched(Contact(Finger.INDEX, sample, sample + 3), True, (sample + 3) / RATE)


class Failing(Policy):
    """Policy with a method that raises an error of a hand."""

    name = title = "failing"
    deadline = 0.02
    fails_in = ""

    def __getattribute__(self, name: str) -> Any:
        if name == type(self).fails_in:
            return self.fail
        return super().__getattribute__(name)

    def fail(self, *_: object) -> Command | None:
        raise HandError("not mine")

    def estimated(self, estimate: Estimate) -> Command | None:
        return None


@pytest.mark.parametrize("method", ["begin", "touched", "estimated", "felt", "slipped", "late"])
def test_policy_that_raises_is_named(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Failing, "fails_in", method)
    sent: list[Command] = []
    loop = GraspLoop(Failing(Grip()), sent.append, RATE)

    def close() -> None:
        loop.begin()
        touch(loop)
        loop.estimated(NARROW, 0.11)
        loop.felt(0.0, 0.115)
        loop.slipped(0.116)
        loop.felt(0.0, 0.2)

    with pytest.raises(InputError, match=r"'failing'.*not mine") as caught:
        close()
    assert caught.value.parameter == "policy"


@given(st.integers(1, 60))
def test_estimate_at_the_deadline_counts_and_a_later_one_does_not(ms: int) -> None:
    loop, sent = make_loop("first_contact", deadline=0.025)
    touch(loop)
    loop.estimated(NARROW, (100 + ms) / RATE)
    late = ms > 25
    assert loop.counts.misses == loop.counts.unused == late
    assert loop.counts.estimates == (not late)
    assert sent[-1] == (Grip().gentle if late else Grip().command_for(45.0))


@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=12))
def test_closing_with_a_contact_but_no_estimate_is_a_miss(
    closings: list[tuple[bool, bool]],
) -> None:
    loop, _ = make_loop("early_exit")
    for number, (contact, answered) in enumerate(closings):
        loop.begin()
        start = 1000 * number
        if contact:
            touch(loop, start + 100)
        if answered:
            loop.estimated(NARROW, (start + 118) / RATE)
        for sample in range(start + 120, start + 300, 5):
            loop.felt(0.0, sample / RATE)
        loop.finish()
    counts = loop.counts
    assert counts.closings == len(closings) + 1
    assert counts.contacts == sum(c for c, _ in closings)
    assert counts.misses == sum(c and not a for c, a in closings)
    assert counts.unused == sum(a and not c for c, a in closings)


def test_passing_time_sends_the_fallback_once() -> None:
    loop, sent = make_loop("first_contact", deadline=0.025)
    touch(loop)
    loop.felt(0.0, 0.125)
    assert loop.counts.misses == 0
    for t in (0.126, 0.2, 0.3):
        loop.felt(0.0, t)
    assert loop.counts.misses == 1
    loop.estimated(NARROW, 0.31)
    loop.finish()
    assert (loop.counts.misses, loop.counts.unused) == (1, 1)
    assert sent == [Grip().approach, Grip().gentle]


@pytest.mark.parametrize("ms", [20, 60])
def test_the_deadline_holds_after_a_retracted_estimate(ms: int) -> None:
    loop, sent = make_loop("first_contact", deadline=0.025)
    touch(loop)
    assert loop.estimated(SHORT, 0.110)
    loop.retract()
    assert loop.estimated(NARROW, (100 + ms) / RATE) == (ms == 20)
    loop.finish()
    assert loop.counts.misses == loop.counts.unused == (ms == 60)
    assert sent[-1] == (Grip().gentle if ms == 60 else Grip().command_for(45.0))


def test_an_estimate_whose_command_is_not_sent_does_not_count() -> None:
    loop = GraspLoop(
        make_policy(POLICIES["first_contact"], Grip(), Truth(30.0), {}), lambda _: False, RATE
    )
    loop.begin()
    touch(loop)
    assert not loop.estimated(NARROW, 0.110)
    assert not loop.finish()
    assert (loop.counts.commands, loop.counts.estimates, loop.counts.misses) == (0, 0, 1)


@pytest.mark.parametrize("name", POLICIES)
def test_the_same_command_is_not_sent_twice(name: str) -> None:
    loop, sent = make_loop(name)
    touch(loop)
    for t in (0.11, 0.12, 0.13, 0.2):
        loop.felt(0.4, t)
    loop.estimated(NARROW, 0.21)
    assert loop.counts.commands == len(sent)
    assert all(a != b for a, b in itertools.pairwise(sent))


def test_taxels_are_measured_from_their_unloaded_level() -> None:
    layout = fingertip_layout()
    columns = layout.columns(ChannelKind.FORCE)
    data = np.zeros((600, len(layout.channels)), np.int16)
    data[:, columns] = 1000
    data[500:, columns[7]] = 2000
    expected = 1000 * layout.channels[columns[7]].scale
    for step in (1, 5, 250):
        taxels = Taxels(layout)
        for _ in range(2):
            taxels.begin()
            felt = [taxels.update(data[i : i + step]) for i in range(0, len(data), step)]
            assert felt[-1] == pytest.approx(expected)
            unloaded = round(REST * layout.rate)
            assert felt[: unloaded // step] == [0.0] * (unloaded // step)
            assert taxels.update(data[:0]) == 0.0


def test_estimate_that_reaches_the_hand_after_the_second_contact_is_overtaken() -> None:
    """The hand's pacing delays the estimate, and the second contact is known only afterwards."""
    for wait, overtaken in ((0.004, 0), (0.006, 1)):
        sent: list[Command] = []
        policy = POLICIES["first_contact"](Grip())
        loop = GraspLoop(policy, sent.append, RATE, 0.025, wait=lambda w=wait: w)  # type: ignore[misc]
        loop.begin()
        touch(loop)
        loop.estimated(NARROW, 0.110)
        loop.finish(Contact(Finger.THUMB, 115, 118))
        assert (loop.counts.estimates, loop.counts.overtaken) == (1 - overtaken, overtaken)
        assert sent[-1] == Grip().command_for(45.0), "the policy acted on it anyway"


@pytest.mark.parametrize("name", ["first_contact", "early_exit", "stiffness"])
def test_withdrawn_contact_leaves_no_trace(name: str) -> None:
    loop, sent = make_loop(name, deadline=0.025)
    first = sent[-1]
    touch(loop)
    loop.estimated(NARROW, 0.118)
    loop.withdrawn()
    assert sent[-1] == first
    counts = loop.counts
    assert (counts.contacts, counts.estimates, counts.withdrawn) == (0, 0, 1)
    loop.felt(0.0, 0.2)
    assert counts.misses == 0
    touch(loop, 300)
    loop.estimated(NARROW, 0.318)
    assert (counts.contacts, counts.estimates) == (1, 1)
    loop.finish()
    loop.withdrawn()
    assert counts.withdrawn == 1


class Feeling(Policy):
    """Policy that acts on force only."""

    name = title = "feeling"

    def felt(self, volts: float, since: float | None) -> Command:
        return Command(0.0, 2.0)


def test_withdrawn_contact_leaves_a_policy_alone_that_uses_no_contact() -> None:
    sent: list[Command] = []
    loop = GraspLoop(Feeling(Grip()), sent.append, RATE)
    loop.begin()
    touch(loop)
    loop.felt(0.3, 0.2)
    loop.withdrawn()
    assert sent == [Grip().approach, Command(0.0, 2.0)]
