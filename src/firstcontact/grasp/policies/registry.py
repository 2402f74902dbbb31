"""All policies by name. A new policy is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from firstcontact.core import InputError
from firstcontact.core.registry import Registry
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policy import Policy, Truth

_HERE = "firstcontact.grasp.policies"

POLICIES: Registry[type[Policy]] = Registry(
    "policy",
    "firstcontact.policies",
    {
        "none": f"{_HERE}.none:NoModulation",
        "force_feedback": f"{_HERE}.force_feedback:ForceFeedback",
        "touch": f"{_HERE}.touch:Touch",
        "first_contact": f"{_HERE}.first_contact:FirstContact",
        "early_exit": f"{_HERE}.early_exit:EarlyExit",
        "blind": f"{_HERE}.blind:Blind",
        "stiffness": f"{_HERE}.stiffness:ByStiffness",
        "slip_reflex": f"{_HERE}.slip_reflex:SlipReflex",
        "stiffness_reflex": f"{_HERE}.stiffness_reflex:StiffnessReflex",
        "weight": f"{_HERE}.weight:ByWeight",
    },
    default="first_contact",
)


def make_policy(
    kind: type[Policy], grip: Grip, truth: Truth, settings: Mapping[str, float]
) -> Policy:
    """A policy for one pinch.

    Parameters
    ----------
    kind
        A class of policies.
    grip
        What is declared of the hand.
    truth
        Of the object, for a policy that is told it.
    settings
        That it was tuned to.
    """
    made: Callable[..., Policy] = kind
    return made(grip, truth, **settings) if kind.needs_truth else made(grip, **settings)


def live_policies() -> list[str]:
    """Those that need no truth: what a real hand can be driven with."""
    return [name for name, policy in POLICIES.items() if not policy.needs_truth]


def live_policy(name: str, grip: Grip | None = None) -> Policy:
    """A policy for a hand whose object is not known.

    Raises
    ------
    InputError
        There is none of that name.
    """
    names = live_policies()
    if name not in names and name not in POLICIES.failed:
        raise InputError(f"no policy is called {name!r}: choose one of {', '.join(names)}")
    return POLICIES.find(name)(grip or Grip())
