"""Policies for a household: slow at the first contact, one force from the second on, a reflex."""

from __future__ import annotations

import pytest

from firstcontact.core import Command, Contact, Finger
from firstcontact.grasp import (
    POLICIES,
    ByStiffness,
    FinalForce,
    GraspLoop,
    Grip,
    Stiffness,
    Task,
    Truth,
    make_policy,
)
from firstcontact.grasp.policies.blind import Blind
from firstcontact.grasp.policies.final_force import PATIENCE, SLOW
from firstcontact.grasp.policies.slip_reflex import SlipReflex
from firstcontact.grasp.policies.stiffness_reflex import StiffnessReflex
from firstcontact.grasp.policies.weight import ByWeight

CONTACT = Contact(Finger.INDEX, 100, 105)
HOUSEHOLD = [name for name, policy in POLICIES.items() if policy.task is Task.HOUSEHOLD]


@pytest.mark.parametrize("name", HOUSEHOLD)
def test_it_slows_down_at_once_and_presses_where_both_fingers_touch(name: str) -> None:
    policy = make_policy(POLICIES[name], Grip(), Truth(30.0), {})
    assert isinstance(policy, FinalForce)
    for _ in range(2):
        assert policy.begin() == Command(0.10, 1.0)
        assert policy.touched(CONTACT, True) == Command(SLOW, 1.0)
        assert policy.felt(0.0, PATIENCE / 2) is None
        assert policy.touched(CONTACT, False) == policy.final
        assert policy.felt(0.0, 2 * PATIENCE) is None
        policy.begin()
        policy.touched(CONTACT, True)
        assert policy.felt(0.0, PATIENCE) == policy.final


def test_a_stalled_drive_builds_the_force_that_is_wanted() -> None:
    for force in (1.0, 3.0, 12.0):
        command = Grip().pressing(force)
        assert command.force == force
        assert command.speed * Grip().push == pytest.approx(1.1 * force)
    assert Grip().pressing(50.0) == Grip().pressing(12.0)


def test_the_force_steps_up_with_the_cautious_end_of_the_estimate() -> None:
    policy = ByStiffness(Grip(), soft=2, firm=6, middle=30, width=2, caution=1.0, unknown=0.25)
    policy.begin()
    assert policy.wanted() == 3.0
    forces = []
    for value, half in ((0.0, 0.0), (30.0, 0.0), (60.0, 30.0), (60.0, 10.0)):
        policy.estimated(Stiffness(value, value - half, value + half, 0.01))
        forces.append(policy.wanted())
    assert forces == pytest.approx([2.0, 4.0, 4.0, 6.0], abs=1e-3)
    policy.begin()
    assert policy.told is None


def test_an_estimate_that_comes_after_the_second_contact_corrects_the_force() -> None:
    policy = ByStiffness(Grip())
    policy.begin()
    policy.touched(CONTACT, True)
    unknown = policy.touched(CONTACT, False)
    told = policy.estimated(Stiffness(90.0, 85.0, 95.0, 0.003))
    assert told is not None
    assert unknown is not None
    assert told.force > unknown.force
    assert policy.late() == told


@pytest.mark.parametrize("kind", [ByStiffness, StiffnessReflex])
def test_an_estimate_by_the_deadline_is_no_miss_however_late_the_second_finger_comes(
    kind: type[ByStiffness],
) -> None:
    sent: list[Command] = []
    loop = GraspLoop(kind(Grip()), sent.append, 1000.0)
    for told in (True, False):
        loop.begin()
        loop.touched(CONTACT, True, 0.105)
        if told:
            loop.estimated(Stiffness(40.0, 35.0, 45.0, 0.01), 0.115)
        loop.felt(0.0, 0.100 + ByStiffness.deadline + 0.002)
        # Who knows goes on as before, who does not goes on more gently.
        assert (sent[-1] == Command(SLOW, 1.0)) is told
        assert (sent[-1].speed < SLOW) is not told
        loop.touched(Contact(Finger.THUMB, 170, 175), False, 0.175)
        loop.done(Contact(Finger.THUMB, 170, 175))
    assert (loop.counts.estimates, loop.counts.misses) == (1, 1)


@pytest.mark.parametrize("kind", [SlipReflex, StiffnessReflex])
def test_each_slip_raises_the_force_up_to_the_hands(
    kind: type[SlipReflex | StiffnessReflex],
) -> None:
    sent: list[Command] = []
    policy = kind(Grip(), boost=2.0)
    loop = GraspLoop(policy, sent.append, 1000.0)
    for _ in range(2):
        loop.begin()
        loop.slipped(0.05)
        loop.touched(CONTACT, True, 0.105)
        loop.touched(Contact(Finger.THUMB, 110, 115), False, 0.115)
        first = sent[-1].force
        told = []
        for time in (0.5, 0.6, 0.7, 0.8):
            loop.slipped(time)
            told.append(sent[-1].force)
        assert told == [min(first * 2**n, 12.0) for n in (1, 2, 3, 4)]
        loop.done()
        before = len(sent)
        loop.slipped(0.9)
        assert len(sent) == before


def test_who_knows_the_weight_presses_with_what_holds_it_within_bounds() -> None:
    def force(mass: float) -> float:
        return ByWeight(Grip(), Truth(50.0, mass), margin=2.0, least=1.0, most=8.0).wanted()

    assert force(0.001) == 1.0
    assert force(0.2) == pytest.approx(2 * 0.2 * 9.81)
    assert force(2.0) == 8.0


def test_the_scale_multiplies_whatever_is_wanted() -> None:
    assert Blind(Grip(), 3.0, scale=0.5).final.force == 1.5
    assert StiffnessReflex(Grip(), soft=2.0, firm=2.0, scale=2.0).final.force == 4.0
