"""Grasp modulation: policies, and the hands that they command."""

from __future__ import annotations

from typing import TYPE_CHECKING

from firstcontact.core.lazy import lazily

if TYPE_CHECKING:
    from firstcontact.grasp.grip import Grip
    from firstcontact.grasp.hand import Hand, HandError, HandLimits
    from firstcontact.grasp.policies.registry import POLICIES
    from firstcontact.grasp.policy import Policy, Stiffness
    from firstcontact.grasp.registry import HANDS, open_hand
else:
    __getattr__ = lazily(
        __name__,
        {
            "grip": "Grip",
            "hand": "Hand HandError HandLimits",
            "policy": "Policy Stiffness",
            "policies.registry": "POLICIES",
            "registry": "HANDS open_hand",
        },
    )

__all__ = [
    "HANDS",
    "POLICIES",
    "Grip",
    "Hand",
    "HandError",
    "HandLimits",
    "Policy",
    "Stiffness",
    "open_hand",
]
