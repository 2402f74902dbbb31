"""Check of a grasp policy, such as that of a plug-in."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial
from math import isfinite
from random import Random

from firstcontact.core import Command, Contact, Estimate, Finger
from firstcontact.grasp import Grip, Policy
from firstcontact.grasp.policy import Truth
from firstcontact.grasp.registry import make_policy

#: Number of closings for each check.
CLOSINGS = 300
_CONTACT = Contact(Finger.THUMB, 1000, 1012)
_METHODS = ("begin", "touched", "estimated", "felt", "slipped", "late")


def check_policy(policy_class: type[Policy]) -> None:
    """Assert that a policy behaves as :class:`~firstcontact.grasp.Policy` requires.

    The policy's commands are finite and within the hand's limits. The policy never presses harder
    or closes faster for a softer object, or for an estimate with a wider interval. After a missed
    deadline it is at least as gentle and slow as for the softest object. A closing does not affect
    the next. The policy has a title and a colour, and each tunable setting a title and values.

    Parameters
    ----------
    policy_class
        Class of the policy.

    Raises
    ------
    AssertionError
        A check failed (the message names it), or there was nothing to check.

    Examples
    --------
    >>> from firstcontact.grasp import POLICIES
    >>> check_policy(POLICIES["touch"])
    """
    assert any(getattr(policy_class, m) is not getattr(Policy, m) for m in _METHODS), (
        f"{policy_class.__name__} overrides no method of Policy: there is nothing to check"
    )
    _declared(policy_class)
    chance = Random(0)  # noqa: S311
    for _ in range(CLOSINGS):
        for settings in _settings(policy_class, chance):
            _within_the_hand(policy_class, settings, chance)
            _leaves_nothing(policy_class, settings, chance)
        _gentler(policy_class, chance)
    _late(policy_class)


def _settings(policy_class: type[Policy], chance: Random) -> Iterator[dict[str, float]]:
    """Yield arguments of a policy: first none, then a random value of each tunable setting."""
    yield {}
    if policy_class.tunables:
        yield {name: chance.choice((*t.tried, *t.few)) for name, t in policy_class.tunables.items()}


def _declared(policy_class: type[Policy]) -> None:
    name, colour = policy_class.name, policy_class.colour
    assert re.fullmatch(r"\w+", name), f"the name {name!r} may contain only letters, digits and _"
    assert policy_class.title.strip(), f"{name} has no title"
    assert re.fullmatch("#[0-9A-Fa-f]{6}", colour), (
        f"{name}: {colour!r} is not a colour like #56B4E9"
    )
    for name, tunable in policy_class.tunables.items():
        assert tunable.tried, f"the setting {name} has no values to try"
        assert tunable.few, f"the setting {name} has no few values for a quick study"
        assert tunable.title, f"the setting {name} has no title"


def _within_the_hand(
    policy_class: type[Policy], settings: dict[str, float], chance: Random
) -> None:
    grip = Grip(force=chance.uniform(0.1, 30), speed=chance.uniform(0.001, 0.5))
    policy = make_policy(policy_class, grip, Truth(_shore(chance)), settings)
    for command in _closing(policy, chance, late=chance.random() < 0.5):
        assert isfinite(command.speed), f"{command}: the speed is not finite"
        assert isfinite(command.force), f"{command}: the force is not finite"
        assert 0 <= command.speed <= grip.speed, f"{command} is not within {grip.speed} m/s"
        assert 0 < command.force <= grip.force, f"{command} is not within {grip.force} N"


def _leaves_nothing(policy_class: type[Policy], settings: dict[str, float], chance: Random) -> None:
    policy = make_policy(policy_class, Grip(), Truth(40.0), settings)
    state = chance.getstate()
    first = _closing(policy, chance)
    chance.setstate(state)
    again = _closing(policy, chance)
    assert again == first, f"a repeated closing gives other commands: {first}, then {again}"


def _gentler(policy_class: type[Policy], chance: Random) -> None:
    """Assert that a policy is never firmer or faster for a softer object or a wider interval."""
    low, high = sorted((_shore(chance), _shore(chance)))
    tight, wide = sorted((chance.uniform(0, 60), chance.uniform(0, 60)))
    value, half = _shore(chance), chance.uniform(0, 30)
    last = partial(_last, policy_class)
    for gentle, firm, case in (
        (last(low, low, half), last(high, high, half), f"{low:g} and {high:g} Shore"),
        (last(30, value, wide), last(30, value, tight), f"+-{wide:g} and +-{tight:g} Shore"),
    ):
        assert gentle.force <= firm.force, f"{case}: {gentle.force} N, then {firm.force} N"
        assert gentle.speed <= firm.speed, f"{case}: {gentle.speed} m/s, then {firm.speed} m/s"


def _late(policy_class: type[Policy]) -> None:
    policy = make_policy(policy_class, Grip(), Truth(50.0), {})
    policy.begin()
    policy.touched(_CONTACT, True)
    fallback = policy.late()
    if policy.deadline is None:
        assert fallback is None, "late() returns a command without a deadline"
        return
    assert 0 < policy.deadline < 1, f"the deadline of {policy.deadline} s is not between 0 and 1 s"
    assert policy_class.estimated is not Policy.estimated, (
        "the policy has a deadline for estimates but does not use them"
    )
    assert fallback is not None, "late() returns no command after the deadline"
    gentle = Grip().gentle
    assert fallback.force <= gentle.force, (
        f"after the deadline its force limit is {fallback.force} N"
    )
    assert fallback.speed <= gentle.speed, (
        f"after the deadline its speed limit is {fallback.speed} m/s"
    )


def _last(policy_class: type[Policy], truth: float, value: float, half: float) -> Command:
    policy = make_policy(policy_class, Grip(), Truth(truth), {})
    return _answers(policy, _around(value, half, 0.015), 0.0)[-1]


def _closing(policy: Policy, chance: Random, late: bool = False) -> list[Command]:
    window = chance.choice((0.003, 0.005, 0.008, 0.015))
    estimate = _around(_shore(chance), chance.uniform(0, 50), window)
    return _answers(policy, None if late else estimate, chance.uniform(-0.1, 3.3))


def _answers(policy: Policy, estimate: Estimate | None, volts: float) -> list[Command]:
    commands = [
        policy.begin(),
        policy.felt(volts, None),
        policy.touched(_CONTACT, True),
        policy.felt(volts, 0.01),
        policy.late() if estimate is None else policy.estimated(estimate),
        policy.touched(_CONTACT, False),
        policy.felt(volts, 0.05),
        policy.slipped(),
    ]
    return [command for command in commands if command is not None]


def _around(value: float, half: float, elapsed: float) -> Estimate:
    return make_estimate(value, max(value - half, 0.0), min(value + half, 100.0), elapsed)


def make_estimate(
    value: float, low: float, high: float, elapsed: float = 0.015, *, final: bool = False
) -> Estimate:
    """Return a stiffness estimate for tests of policies, as if it was computed without delay.

    Parameters
    ----------
    value, low, high
        Estimate, and lower and upper bound of its interval, Shore A.
    elapsed
        Length of the signal after the contact that the estimate used, s.
    final
        True if no later estimate of the closing follows.
    """
    return Estimate(
        value=value,
        low=low,
        high=high,
        level=0.9,
        elapsed=elapsed,
        available=elapsed,
        final=final,
        model="",
        contact=_CONTACT,
        complete=_CONTACT.decided,
        epoch=0,
        host=0.0,
        compute=0.0,
    )


def _shore(chance: Random) -> float:
    return chance.choice((0.0, 100.0, *(chance.uniform(0, 100) for _ in range(8))))
