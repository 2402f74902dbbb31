"""What every grasp policy keeps to."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import isfinite
from random import Random

from firstcontact.core import Command, Contact, Finger
from firstcontact.grasp import Grip, Policy, Stiffness, Truth, make_policy

#: Closings that each rule is held against.
CLOSINGS = 300
_CONTACT = Contact(Finger.THUMB, 1000, 1012)
_METHODS = ("begin", "touched", "estimated", "felt", "slipped", "late")


def check_policy(kind: type[Policy]) -> None:
    """Hold a policy against what its registry promises.

    Its commands are finite and within the hand. It closes on nothing softer harder or faster than
    on what is firmer, nor where it is less sure. A deadline that passes has an answer no
    harder or faster than what the softest thing bears. A closing leaves nothing to the next.
    What it says of itself for tables and figures is whole.

    Parameters
    ----------
    kind
        The class.

    Raises
    ------
    AssertionError
        Says what it does otherwise; or it does nothing that could be checked.

    Examples
    --------
    >>> from firstcontact.grasp.policies.touch import Touch
    >>> check_policy(Touch)
    """
    assert any(getattr(kind, m) is not getattr(Policy, m) for m in _METHODS), (
        f"{kind.__name__} does what Policy does and nothing else: there is nothing to check"
    )
    _declared(kind)
    chance = Random(0)  # noqa: S311
    for _ in range(CLOSINGS):
        for settings in _settings(kind, chance):
            _within_the_hand(kind, settings, chance)
            _leaves_nothing(kind, settings, chance)
        _gentler(kind, chance)
    _late(kind)


def _settings(kind: type[Policy], chance: Random) -> Iterator[dict[str, float]]:
    """None, and what a study may tune it to."""
    yield {}
    if kind.tunables:
        yield {name: chance.choice((*t.tried, *t.few)) for name, t in kind.tunables.items()}


def _declared(kind: type[Policy]) -> None:
    named = [(kind.name, kind.title, kind.colour)]
    named += [(v.key, v.title, v.colour) for v in kind.variants]
    for name, title, colour in named:
        assert re.fullmatch(r"\w+", name), f"the name {name!r} is not of letters, digits and _"
        assert title.strip(), f"{name} has no title"
        assert re.fullmatch("#[0-9A-Fa-f]{6}", colour), f"{name}: {colour!r} is no colour: #56B4E9"
    keys = [v.key for v in kind.variants]
    assert len(set(keys)) == len(keys), f"two variants have one name: {keys}"
    for name, tunable in kind.tunables.items():
        assert tunable.tried, f"the setting {name} has no values to try"
        assert tunable.few, f"the setting {name} has no few values for a quick study"
        assert tunable.title, f"the setting {name} has no title"


def _within_the_hand(kind: type[Policy], settings: dict[str, float], chance: Random) -> None:
    grip = Grip(force=chance.uniform(0.1, 30), speed=chance.uniform(0.001, 0.5))
    policy = make_policy(kind, grip, Truth(_shore(chance)), settings)
    for command in _closing(policy, chance, late=chance.random() < 0.5):
        assert isfinite(command.speed), f"{command}: the speed is not finite"
        assert isfinite(command.force), f"{command}: the force is not finite"
        assert 0 <= command.speed <= grip.speed, f"{command} is not within {grip.speed} m/s"
        assert 0 < command.force <= grip.force, f"{command} is not within {grip.force} N"


def _leaves_nothing(kind: type[Policy], settings: dict[str, float], chance: Random) -> None:
    policy = make_policy(kind, Grip(), Truth(40.0), settings)
    state = chance.getstate()
    first = _closing(policy, chance)
    chance.setstate(state)
    again = _closing(policy, chance)
    assert again == first, f"the same closing again is answered otherwise: {first}, then {again}"


def _gentler(kind: type[Policy], chance: Random) -> None:
    """On what is softer, and where it is less sure."""
    low, high = sorted((_shore(chance), _shore(chance)))
    tight, wide = sorted((chance.uniform(0, 60), chance.uniform(0, 60)))
    value, half = _shore(chance), chance.uniform(0, 30)
    for gentle, firm, what in (
        (_last(kind, low, low, half), _last(kind, high, high, half), f"{low:g} and {high:g} Shore"),
        (
            _last(kind, 30, value, wide),
            _last(kind, 30, value, tight),
            f"+-{wide:g} and +-{tight:g}",
        ),
    ):
        assert gentle.force <= firm.force, f"{what}: {gentle.force} N, then {firm.force} N"
        assert gentle.speed <= firm.speed, f"{what}: {gentle.speed} m/s, then {firm.speed} m/s"


def _late(kind: type[Policy]) -> None:
    policy = make_policy(kind, Grip(), Truth(50.0), {})
    policy.begin()
    policy.touched(_CONTACT, True)
    fallback = policy.late()
    if policy.deadline is None:
        assert fallback is None, "without a deadline nothing is late"
        return
    assert 0 < policy.deadline < 1, f"the deadline of {policy.deadline} s is not within a second"
    assert kind.estimated is not Policy.estimated, "it has a deadline for estimates and uses none"
    assert fallback is not None, "the deadline passes, and it has no answer"
    gentle = Grip().gentle
    assert fallback.force <= gentle.force, f"late, it may press with {fallback.force} N"
    assert fallback.speed <= gentle.speed, f"late, it may close at {fallback.speed} m/s"


def _last(kind: type[Policy], truth: float, value: float, half: float) -> Command:
    policy = make_policy(kind, Grip(), Truth(truth), {})
    return _answers(policy, _around(value, half, 0.015), 0.0)[-1]


def _closing(policy: Policy, chance: Random, late: bool = False) -> list[Command]:
    window = chance.choice((0.003, 0.005, 0.008, 0.015))
    estimate = _around(_shore(chance), chance.uniform(0, 50), window)
    return _answers(policy, None if late else estimate, chance.uniform(-0.1, 3.3))


def _answers(policy: Policy, estimate: Stiffness | None, volts: float) -> list[Command]:
    said = [
        policy.begin(),
        policy.felt(volts, None),
        policy.touched(_CONTACT, True),
        policy.felt(volts, 0.01),
        policy.late() if estimate is None else policy.estimated(estimate),
        policy.touched(_CONTACT, False),
        policy.felt(volts, 0.05),
        policy.slipped(),
    ]
    return [command for command in said if command is not None]


def _around(value: float, half: float, duration: float) -> Stiffness:
    return Stiffness(value, max(value - half, 0.0), min(value + half, 100.0), duration)


def _shore(chance: Random) -> float:
    """The ends of the scale come often."""
    return chance.choice((0.0, 100.0, *(chance.uniform(0, 100) for _ in range(8))))
