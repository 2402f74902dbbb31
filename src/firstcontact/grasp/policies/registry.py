"""All policies by name. A new policy is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from firstcontact.core import InputError, Registry
from firstcontact.grasp._grip import Grip
from firstcontact.grasp._policy import Policy, Truth

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
    base="firstcontact.grasp._policy:Policy",
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
    """Return the names of policies that may drive a real hand: those that need no truth.

    Plug-ins are among them unseen: they are imported when they are chosen.
    """
    own = POLICIES.own
    return [name for name in POLICIES.names if name not in own or not POLICIES[name].needs_truth]


def live_policy(name: str, grip: Grip | None = None) -> Policy:
    """A policy for a hand whose object is not known.

    Raises
    ------
    InputError
        There is none of that name.
    """
    kind = POLICIES.find(name)
    if kind.needs_truth:
        others = ", ".join(other for other in live_policies() if other != name)
        raise InputError(
            f"policy {name!r} needs to know the object beforehand: choose one of {others}"
        )
    with POLICIES.calling(name):
        return kind(grip or Grip())
