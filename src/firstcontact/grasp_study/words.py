"""How policies are called and coloured, the same on every figure."""

from __future__ import annotations

from firstcontact.core.palette import BLUE, GREEN, GREY, INK, ORANGE, PURPLE, RED

NAMES = {
    "none": "no modulation",
    "feedback": "force feedback",
    "feedback_fast": "force feedback, ideal sheet",
    "touch": "gentle at touch, no estimate",
    "first_contact": "first contact",
    "early_exit": "early exit",
    "oracle": "oracle",
}
COLOURS = {
    "none": GREY,
    "feedback": ORANGE,
    "feedback_fast": RED,
    "touch": PURPLE,
    "first_contact": BLUE,
    "early_exit": GREEN,
    "oracle": INK,
}


def name(variant: str) -> str:
    """As readers see it."""
    return NAMES.get(variant, variant.replace("_", " "))


def colour(variant: str) -> str:
    """Of its bars and lines."""
    return COLOURS.get(variant, "#56B4E9")
