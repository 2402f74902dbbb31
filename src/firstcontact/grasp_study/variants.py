"""What is compared: a policy and the force array it feels with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from firstcontact.grasp.grip import Grip
from firstcontact.grasp.policies.force_feedback import Feedback, ForceFeedback
from firstcontact.grasp.policies.registry import POLICIES
from firstcontact.grasp.policies.touch import Touch
from firstcontact.grasp.policy import Policy
from firstcontact.twin.sensor import OPTIMISTIC, VelostatParameters

FEEDBACK = ForceFeedback.name
SLOW, FAST = "feedback", "feedback_fast"
#: Knows of the contact and of no stiffness.
CONTROL = Touch.name


@dataclass(frozen=True, slots=True)
class Variant:
    """One way of closing.

    Parameters
    ----------
    key
        In tables and files.
    policy
        Name in the registry.
    velostat
        The force array of both fingers; None for the twin's own, drawn for each pinch.
    """

    key: str
    policy: str
    velostat: VelostatParameters | None = None

    def make(self, grip: Grip, shore_a: float, tuned: Mapping[str, Feedback]) -> Policy:
        """A policy for one pinch; force feedback as it was tuned for this force array."""
        if self.policy == FEEDBACK:
            return ForceFeedback(grip, tuned.get(self.key))
        return POLICIES[self.policy](grip, shore_a)


#: Force feedback twice, every other policy of the registry as it is.
VARIANTS: tuple[Variant, ...] = tuple(
    variant
    for name in POLICIES
    for variant in (
        (Variant(SLOW, name), Variant(FAST, name, OPTIMISTIC))
        if name == FEEDBACK
        else (Variant(name, name),)
    )
)
