"""Registries of hands and policies. To add one, write a module and add a line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from firstcontact.core import ArgumentError, Registry
from firstcontact.core.registry import foreign_errors
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._safe import SafeHand
from firstcontact.grasp.hand import Hand
from firstcontact.grasp.policy import Policy, Truth
from firstcontact.grasp.separate import SeparateHand, can_separate

#: Classes of hands by name, including those of plug-ins. The twin's hand needs a device, so it
#: joins as a plug-in does: see ``firstcontact.hands`` in ``pyproject.toml``.
HANDS: Registry[type[Hand]] = Registry(
    "hand",
    "firstcontact.hands",
    {
        "print": "firstcontact.grasp.printing:PrintHand",
        "ability": "firstcontact.grasp.ability:AbilityHand",
    },
    base="firstcontact.grasp.hand:Hand",
)
_PAYLOAD = "firstcontact.grasp.payload_policies"
_HOUSEHOLD = "firstcontact.grasp.household_policies"
#: Classes of grasp policies by name, including those of plug-ins.
POLICIES: Registry[type[Policy]] = Registry(
    "policy",
    "firstcontact.policies",
    {
        "touch": f"{_PAYLOAD}:Touch",
        "first_contact": f"{_PAYLOAD}:FirstContact",
        "early_exit": f"{_PAYLOAD}:EarlyExit",
        "blind": f"{_HOUSEHOLD}:Blind",
        "stiffness": f"{_HOUSEHOLD}:ByStiffness",
        "slip_reflex": f"{_HOUSEHOLD}:SlipReflex",
        "stiffness_reflex": f"{_HOUSEHOLD}:StiffnessReflex",
        "weight": f"{_HOUSEHOLD}:ByWeight",
    },
    default="first_contact",
    base="firstcontact.grasp.policy:Policy",
)


def find_hand(hand: object) -> type[Hand] | Hand:
    if isinstance(hand, str):
        return HANDS.find(hand)
    if not isinstance(hand, Hand):
        raise ArgumentError(
            f"{hand!r} is not a hand: give a name, or an instance of firstcontact.grasp.Hand",
            parameter="hand",
        )
    return hand._hand if isinstance(hand, SafeHand) else hand


def make_hand(kind: type[Hand], port: str | None = None, source: object = None) -> Hand:
    """Return a hand that is not connected yet.

    It runs in a process of its own if its class says so.
    """
    made: Callable[[Any], Hand] = kind
    with HANDS.convert_errors(kind.name):
        if kind.of_source is None:
            is_separate = kind.separate and can_separate(kind)
            return SeparateHand(kind, port) if is_separate else made(port)
        if source is None:
            raise ArgumentError(
                f"the hand {kind.name!r} needs a source, which is missing: open the hand's "
                "source and pass it"
            )
        return made(source)


def open_hand(
    hand: str | Hand, port: str | None = None, *, source: object = None, silence: float = 1.0
) -> SafeHand:
    """Return a hand that lets go if the program fails or hangs. Use it in a ``with`` block.

    Parameters
    ----------
    hand
        Name in :data:`HANDS`, or a hand that is not connected yet.
    port
        Port of a named hand, such as "/dev/ttyUSB0"; None for its default port.
    source
        Source of samples that drives the named hand, such as the twin. Open the source first, and
        keep it open as long as the hand.
    silence
        Time without a call of ``send`` or ``alive`` after which the hand lets go, s.

    Raises
    ------
    InputError
        No hand has this name, the hand's port, source or package is missing, or ``silence`` is not
        above 0.
    """
    if isinstance(hand, SafeHand):
        return hand
    made = hand if isinstance(hand, Hand) else make_hand(HANDS.find(hand), port, source)
    return SafeHand(made, silence=silence)


def make_policy(
    kind: type[Policy], grip: Grip, truth: Truth, settings: Mapping[str, float]
) -> Policy:
    made: Callable[..., Policy] = kind
    return made(grip, truth, **settings) if kind.needs_truth else made(grip, **settings)


def live_policies() -> list[str]:
    built_in = POLICIES.builtin_names
    return [
        name for name in POLICIES.names if name not in built_in or not POLICIES[name].needs_truth
    ]


def find_policy(policy: object) -> type[Policy] | Policy:
    """Return the policy class of a name. A policy class or instance is returned unchanged.

    Raise InputError for anything else.
    """
    kind = policy
    if isinstance(policy, str):
        if policy not in POLICIES.names:
            raise ArgumentError(
                f"no policy is called {policy!r}: choose one of {', '.join(live_policies())}",
                parameter="policy",
            )
        kind = POLICIES.find(policy)
    if not (isinstance(kind, Policy) or (isinstance(kind, type) and issubclass(kind, Policy))):
        raise ArgumentError(
            f"{policy!r} is not a policy: give a name, a firstcontact.grasp.Policy or an instance",
            parameter="policy",
        )
    if kind.needs_truth:
        raise ArgumentError(
            f"policy {kind.name!r} must know the object in advance, so it is for simulations only: "
            f"choose one of {', '.join(live_policies())}",
            parameter="policy",
        )
    return kind


def live_policy(policy: str | type[Policy] | Policy, grip: Grip | None = None) -> Policy:
    kind = find_policy(policy)
    if isinstance(kind, Policy):
        return kind
    with foreign_errors(f"policy {kind.name!r}"), POLICIES.convert_errors(kind.name):
        return kind(grip or Grip())
