"""Registry of policies. To add a policy, write one file and add one line here."""

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
    """Return a policy for one pinch.

    Parameters
    ----------
    kind
        Class of the policy.
    grip
        Declared properties of the hand.
    truth
        Properties of the object, for a policy that needs them.
    settings
        Tuned settings.
    """
    made: Callable[..., Policy] = kind
    return made(grip, truth, **settings) if kind.needs_truth else made(grip, **settings)


def live_policies() -> list[str]:
    """Return the names of the policies for real hands, which need no knowledge of the object.

    All plug-ins are included, because the needs of a plug-in are known only after its import.
    """
    built_in = POLICIES.builtin_names
    return [
        name for name in POLICIES.names if name not in built_in or not POLICIES[name].needs_truth
    ]


def live_policy(name: str, grip: Grip | None = None) -> Policy:
    """Return a policy for a hand that does not know the object.

    Raises
    ------
    InputError
        No policy has that name, or the policy needs knowledge that only a simulated hand has.
    """
    kind = POLICIES.find(name)
    if kind.needs_truth:
        choices = ", ".join(live_policies())
        raise InputError(
            f"policy {name!r} must know the object in advance, so it is for simulations only: "
            f"choose one of {choices}"
        )
    with POLICIES.calling(name):
        return kind(grip or Grip())
