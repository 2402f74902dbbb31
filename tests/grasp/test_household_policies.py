"""Household policies: slow at first contact, one force after the second, slip reflex."""

import pytest

from firstcontact.core import Command, Contact, Finger
from firstcontact.grasp import POLICIES, Grip
from firstcontact.grasp.household_policies import (
    PATIENCE,
    SLOW,
    ByStiffness,
    ByWeight,
    FinalForce,
    SlipReflex,
    StiffnessReflex,
)
from firstcontact.grasp.loop import GraspLoop
from firstcontact.grasp.policy import Task, Truth
from firstcontact.grasp.registry import make_policy
from firstcontact.testing import make_estimate

CONTACT = Contact(Finger.INDEX, 100, 105)
HOUSEHOLD = [name for name, policy in POLICIES.items() if policy.task is Task.HOUSEHOLD]


@pytest.mark.parametrize("name", HOUSEHOLD)
def test_policy_slows_down_at_first_contact_and_presses_at_the_second(name: str) -> None:
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


def test_force_steps_up_with_the_lowered_estimate() -> None:
    policy = ByStiffness(Grip(), soft=2, firm=6, middle=30, width=2, caution=1.0, unknown=0.25)
    policy.begin()
    assert policy.target_force() == 3.0
    forces = []
    for value, half in ((0.0, 0.0), (30.0, 0.0), (60.0, 30.0), (60.0, 10.0)):
        policy.estimated(make_estimate(value, value - half, value + half, 0.01))
        forces.append(policy.target_force())
    assert forces == pytest.approx([2.0, 4.0, 4.0, 6.0], abs=1e-3)
    policy.begin()
    assert policy.estimate is None


@pytest.mark.parametrize("kind", [ByStiffness, StiffnessReflex])
def test_estimate_by_the_deadline_counts_even_if_the_second_finger_is_late(
    kind: type[ByStiffness],
) -> None:
    sent: list[Command] = []
    loop = GraspLoop(kind(Grip()), sent.append, 1000.0)
    for has_estimate in (True, False):
        loop.begin()
        loop.touched(CONTACT, True, 0.105)
        if has_estimate:
            loop.estimated(make_estimate(40.0, 35.0, 45.0, 0.01), 0.115)
        loop.felt(0.0, 0.100 + ByStiffness.deadline + 0.002)
        # With an estimate the speed stays; without one the policy becomes gentler.
        assert (sent[-1] == Command(SLOW, 1.0)) is has_estimate
        assert (sent[-1].speed < SLOW) is not has_estimate
        loop.touched(Contact(Finger.THUMB, 170, 175), False, 0.175)
        loop.finish(Contact(Finger.THUMB, 170, 175))
    assert (loop.counts.estimates, loop.counts.misses) == (1, 1)


@pytest.mark.parametrize("kind", [SlipReflex, StiffnessReflex])
def test_each_slip_raises_the_force_up_to_the_hands_limit(
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
        forces = []
        for time in (0.5, 0.6, 0.7, 0.8):
            loop.slipped(time)
            forces.append(sent[-1].force)
        assert forces == [min(first * 2**n, 12.0) for n in (1, 2, 3, 4)]
        loop.finish()
        count = len(sent)
        loop.slipped(0.9)
        assert len(sent) == count


def test_weight_policy_presses_with_the_holding_force_within_bounds() -> None:
    def force(mass: float) -> float:
        return ByWeight(Grip(), Truth(50.0, mass), margin=2.0, least=1.0, most=8.0).target_force()

    assert force(0.001) == 1.0
    assert force(0.2) == pytest.approx(2 * 0.2 * 9.81)
    assert force(2.0) == 8.0
