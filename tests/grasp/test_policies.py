"""What every registered policy keeps to; a new one is held to it by being registered."""

from __future__ import annotations

from math import inf, isfinite, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firstcontact.core import Command, Contact, Finger, InputError
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policies.early_exit import EarlyExit
from firstcontact.grasp.policies.first_contact import FirstContact
from firstcontact.grasp.policies.force_feedback import Feedback, ForceFeedback
from firstcontact.grasp.policies.registry import LIVE, POLICIES, live_policy
from firstcontact.grasp.policy import Policy, Stiffness

EVERY = pytest.mark.parametrize("name", POLICIES)
CONTACT = Contact(Finger.THUMB, 1000, 1012)
SHORE = st.floats(0.0, 100.0)
VOLTS = st.floats(-0.1, 3.3)


def stiffness(value: float, low: float, high: float, ms: float = 15.0) -> Stiffness:
    return Stiffness(value, low, high, 1e-3 * ms)


def commands(
    policy: Policy, value: float, half: float, ms: float, volts: float, late: bool
) -> list[Command]:
    said = [
        policy.begin(),
        policy.felt(volts, None),
        policy.touched(CONTACT, True),
        policy.felt(volts, 0.01),
        policy.late() if late else policy.estimated(_around(value, half, ms)),
        policy.touched(CONTACT, False),
        policy.felt(volts, 0.05),
    ]
    return [c for c in said if c is not None]


def _around(value: float, half: float, ms: float = 15.0) -> Stiffness:
    return stiffness(value, max(value - half, 0.0), min(value + half, 100.0), ms)


@EVERY
@given(
    truth=SHORE, value=SHORE, half=st.floats(0, 50), ms=st.sampled_from((3.0, 5.0, 8.0, 15.0)),
    volts=VOLTS, late=st.booleans(), force=st.floats(0.1, 30), speed=st.floats(0.001, 0.5),
)  # fmt: skip
def test_commands_are_finite_and_within_the_hand(
    name: str, truth: float, value: float, half: float, ms: float, volts: float, late: bool,
    force: float, speed: float,
) -> None:  # fmt: skip
    policy = POLICIES[name](Grip(force=force, speed=speed), truth)
    for command in commands(policy, value, half, ms, volts, late):
        assert isfinite(command.speed)
        assert 0 <= command.speed <= speed
        assert isfinite(command.force)
        assert 0 < command.force <= force


@EVERY
@given(one=SHORE, other=SHORE, half=st.floats(0, 30))
def test_softer_is_never_closed_on_harder_or_faster(
    name: str, one: float, other: float, half: float
) -> None:
    low, high = sorted((one, other))
    soft, firm = (
        commands(POLICIES[name](Grip(), v), v, half, 15.0, 0.0, False)[-1] for v in (low, high)
    )
    assert soft.force <= firm.force
    assert soft.speed <= firm.speed


@EVERY
@given(value=SHORE, one=st.floats(0, 60), other=st.floats(0, 60))
def test_less_sure_is_never_harder_or_faster(
    name: str, value: float, one: float, other: float
) -> None:
    tight, wide = sorted((one, other))
    sure, unsure = (
        commands(POLICIES[name](Grip(), 30.0), value, half, 15.0, 0.0, False)[-1]
        for half in (tight, wide)
    )
    assert unsure.force <= sure.force
    assert unsure.speed <= sure.speed


@EVERY
def test_late_means_the_declared_fallback(name: str) -> None:
    policy = POLICIES[name](Grip(), 50.0)
    policy.begin()
    policy.touched(CONTACT, True)
    assert (policy.late() is None) == (policy.deadline is None)
    if policy.deadline is not None:
        assert policy.late() == Grip().gentle


@EVERY
@given(value=SHORE, volts=VOLTS)
def test_a_closing_leaves_nothing_to_the_next(name: str, value: float, volts: float) -> None:
    policy = POLICIES[name](Grip(), 40.0)
    first = commands(policy, value, 5.0, 15.0, volts, False)
    assert commands(policy, value, 5.0, 15.0, volts, False) == first


@EVERY
def test_it_is_called_what_it_is_registered_as(name: str) -> None:
    assert POLICIES[name](Grip(), 30.0).name == name


def test_live_has_all_but_the_oracle() -> None:
    assert set(POLICIES) - set(LIVE) == {"oracle"}
    for name in LIVE:
        assert live_policy(name).name == name
    with pytest.raises(InputError, match="no policy is called 'oracle': choose one of none"):
        live_policy("oracle")


@given(SHORE)
def test_the_moving_mass_at_the_granted_speed_presses_to_the_dent(shore_a: float) -> None:
    grip = Grip(speed=inf)
    energy = grip.mass * grip.speed_for(shore_a) ** 2 / 2
    assert energy == pytest.approx(0.4 * grip.stiffness(shore_a) * grip.dent**2.5)


def test_the_force_stays_within_the_margins_of_what_holds_the_payload() -> None:
    grip = Grip()
    assert grip.holding == pytest.approx(0.2 * 9.81)
    assert grip.force_for(0) == pytest.approx(1.3 * grip.holding)
    assert grip.force_for(100) == pytest.approx(2.0 * grip.holding)
    assert grip.force_for(nan) == grip.force_for(0)
    assert Grip(force=1.0).force_for(100) == 1.0


def test_feedback_acts_once_a_closing_and_only_above_its_threshold() -> None:
    policy = ForceFeedback(Grip(), Feedback(0.1, 3.0, 0.02, 2.0))
    for _ in range(2):
        assert policy.begin() == Command(Grip().speed, 3.0)
        assert policy.felt(0.1, None) is None
        assert policy.felt(0.11, None) == Command(0.02, 2.0)
        assert policy.felt(0.5, 0.1) is None


def test_first_contact_waits_for_its_window_and_early_exit_for_a_tight_interval() -> None:
    patient, quick = FirstContact(Grip()), EarlyExit(Grip(), tight=20.0)
    for policy in (patient, quick):
        policy.begin()
    wide, tight = _around(50.0, 15.0, 3.0), _around(50.0, 9.0, 5.0)
    assert patient.estimated(wide) is patient.estimated(tight) is None
    assert patient.estimated(_around(50.0, 15.0)) == Grip().command_for(35.0)
    assert quick.estimated(wide) is None
    assert quick.estimated(tight) == Grip().command_for(41.0)
    assert quick.estimated(_around(50.0, 5.0)) is None
    quick.begin()
    assert quick.estimated(_around(50.0, 40.0, 15.0)) == Grip().command_for(10.0)
