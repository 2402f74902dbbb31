"""Conformance tests of all registered policies, plug-ins included."""

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command, Contact, Estimate, InputError
from firstcontact.grasp import POLICIES, Grip, Policy
from firstcontact.grasp.payload_policies import EarlyExit, FirstContact, Touch
from firstcontact.grasp.policy import Task
from firstcontact.grasp.registry import live_policies, live_policy
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
