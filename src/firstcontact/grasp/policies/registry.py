"""All policies by name. A new policy is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable

from firstcontact.core import InputError
from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policies.early_exit import EarlyExit
from firstcontact.grasp.policies.first_contact import FirstContact
from firstcontact.grasp.policies.force_feedback import ForceFeedback
from firstcontact.grasp.policies.none import NoModulation
from firstcontact.grasp.policies.oracle import Oracle
from firstcontact.grasp.policies.touch import Touch
from firstcontact.grasp.policy import Policy

#: From what is declared of the hand and the true Shore A, which only the oracle looks at.
Make = Callable[[Grip, float], Policy]

POLICIES: dict[str, Make] = {
    NoModulation.name: lambda grip, _: NoModulation(grip),
    ForceFeedback.name: lambda grip, _: ForceFeedback(grip),
    Touch.name: lambda grip, _: Touch(grip),
    FirstContact.name: lambda grip, _: FirstContact(grip),
    EarlyExit.name: lambda grip, _: EarlyExit(grip),
    Oracle.name: Oracle,
}

#: Those that need no truth: what a real hand can be driven with.
LIVE = tuple(name for name in POLICIES if name != Oracle.name)


def live_policy(name: str, grip: Grip | None = None) -> Policy:
    """A policy for a hand whose object is not known.

    Raises
    ------
    InputError
        There is none of that name.
    """
    if name not in LIVE:
        raise InputError(f"no policy is called {name!r}: choose one of {', '.join(LIVE)}")
    return POLICIES[name](grip or Grip(), 0.0)
