"""Policies: conformance of all that are registered, and those for household objects."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command, Contact, Estimate, Finger, InputError
from firstcontact.grasp import POLICIES, Grip, Policy
from firstcontact.grasp.household_policies import (
    PATIENCE,
    SLOW,
    ByStiffness,
    ByWeight,
    SlipReflex,
    StiffnessReflex,
)
from firstcontact.grasp.loop import GraspLoop
from firstcontact.grasp.payload_policies import EarlyExit, FirstContact, Touch
from firstcontact.grasp.policy import Task, Truth
from firstcontact.grasp.registry import live_policies, live_policy, make_policy
from firstcontact.testing import check_policy, make_estimate
from firstcontact.twin.mechanics import FingerParameters

SHORE = st.floats(0.0, 100.0)


def _around(value: float, half: float, ms: float = 15.0) -> Estimate:
    return make_estimate(value, max(value - half, 0.0), min(value + half, 100.0), 1e-3 * ms)


@pytest.mark.parametrize("name", POLICIES)
def test_registered_policy_passes_the_conformance_check(name: str) -> None:
    check_policy(POLICIES[name])


def test_live_policies_are_all_that_need_no_truth() -> None:
    assert set(POLICIES) - set(live_policies()) == {"weight"}
    for name in live_policies():
        assert live_policy(name).name == name
    with pytest.raises(InputError, match="weight"):
        live_policy("weight")


def test_policy_inputs_follow_from_the_overridden_methods() -> None:
    piezos = {name for name, policy in POLICIES.items() if policy.uses_piezos()}
    household = {name for name, policy in POLICIES.items() if policy.task is Task.HOUSEHOLD}
    assert piezos == {"touch", "first_contact", "early_exit"} | household
    reflexes = {name for name, policy in POLICIES.items() if policy.has_reflex()}
    assert reflexes == {"slip_reflex", "stiffness_reflex"}


class Wild(Touch):
    """Faulty policy that exceeds the hand's force."""

    def touched(self, contact: Contact, first: bool) -> Command:
        return Command(self.grip.speed, 2 * self.grip.force)


class Rash(FirstContact):
    """Faulty policy that presses soft objects harder."""

    def estimated(self, estimate: Estimate) -> Command:
        return self.grip.command_for(100 - estimate.value)


class Once(EarlyExit):
    """Faulty policy that acts in its first closing only."""

    def begin(self) -> Command:
        return self.grip.approach


@pytest.mark.parametrize("kind", [Wild, Rash, Once])
def test_conformance_check_rejects_a_faulty_policy(kind: type[Policy]) -> None:
    with pytest.raises(AssertionError):
        check_policy(kind)


@given(SHORE)
def test_moving_mass_at_the_commanded_speed_presses_to_the_dent(shore_a: float) -> None:
    grip = Grip(speed=inf)
    energy = grip.mass * grip.speed_for(shore_a) ** 2 / 2
    assert energy == pytest.approx(0.4 * grip.stiffness(shore_a) * grip.dent**2.5)


def test_force_stays_within_the_margins_of_the_holding_force() -> None:
    grip = Grip()
    assert grip.holding == pytest.approx(0.2 * 9.81)
    assert grip.force_for(0) == pytest.approx(1.3 * grip.holding)
    assert grip.force_for(100) == pytest.approx(2.0 * grip.holding)
    assert grip.force_for(nan) == grip.force_for(0)
    assert Grip(force=1.0).force_for(100) == 1.0


def test_first_contact_follows_each_estimate_and_early_exit_waits_for_a_tight_interval() -> None:
    prompt, quick = FirstContact(Grip()), EarlyExit(Grip(), tight=20.0)
    for policy in (prompt, quick):
        policy.begin()
    wide, tight = _around(50.0, 15.0, 3.0), _around(50.0, 9.0, 5.0)
    assert prompt.estimated(wide) == Grip().command_for(35.0)
    assert prompt.estimated(tight) == Grip().command_for(41.0)
    assert quick.estimated(wide) is None
    assert quick.estimated(tight) == Grip().command_for(41.0)
    assert quick.estimated(_around(50.0, 5.0)) is None
    quick.begin()
    assert quick.estimated(_around(50.0, 40.0, 15.0)) == Grip().command_for(10.0)


def test_a_grip_assumes_the_pad_of_the_twin() -> None:
    assert Grip().pad_modulus == FingerParameters().pad_modulus


CONTACT = Contact(Finger.INDEX, 100, 105)
HOUSEHOLD = [name for name, policy in POLICIES.items() if policy.task is Task.HOUSEHOLD]


@pytest.mark.parametrize("name", HOUSEHOLD)
def test_policy_slows_down_at_first_contact_and_presses_at_the_second(name: str) -> None:
    policy = make_policy(POLICIES[name], Grip(), Truth(30.0), {})
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
