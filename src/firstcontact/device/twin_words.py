"""Texts of the orders that the twin obeys, and of the markers that it sends."""

from __future__ import annotations

from firstcontact.core import ArgumentError, Command
from firstcontact.core.text import parse_float

#: Prefix of all markers of the twin.
TWIN = "twin: "
#: Prefixes of an order to the hand, and of an order that selects the object.
HAND = "hand:"
OBJECT = "object:"
#: Prefix of an order to the simulated person who tests the fingertips.
TESTER = "tester:"
#: Order to begin the next closing immediately.
CLOSE_ORDER = f"{HAND} close"
#: Prefix of the answer to an accepted order.
ACCEPTED = f"{TWIN}told "
PEAK, LOST = f"{TWIN}peak ", f"{TWIN}lost "
#: Prefixes of the markers about the hand; other markers name an object.
ABOUT_HAND = (PEAK, f"{TWIN}hand ", ACCEPTED, LOST)


def order_text(order: Command | None) -> str:
    return f"{HAND} release" if order is None else f"{HAND} {order.speed:.4f} {order.force:.3f}"


def object_text(name: str) -> str:
    return f"{OBJECT} {name}"


def tester_text(task: str) -> str:
    """Return the command text that makes the simulated tester do a task.

    ``task`` is "rest", "tap index" or "press thumb".
    """
    return f"{TESTER} {task}"


def is_accepted(marker: str, order: str) -> bool:
    return marker == f"{ACCEPTED}{order}"


def read_order(text: str) -> Command | None:
    """Parse an order to the twin's hand. Return the command; None for the order to open.

    Raises ArgumentError for any other text.
    """
    words = text.removeprefix(HAND).split()
    if words == ["release"]:
        return None
    try:
        speed, force = map(parse_float, words)
    except ValueError as error:
        raise ArgumentError(
            f"the twin's hand cannot follow the order {text!r}: give a speed in m/s and a force in "
            "N, or the word release"
        ) from error
    return Command(speed, force)


def peak_text(peak: float) -> str:
    return f"{PEAK}{peak:.1f} N"


def lost_text(how: str) -> str:
    return f"{LOST}{how}"


def parse_lost_object(text: str) -> str | None:
    """Return "dropped" or "broken" if the marker ``text`` reports a lost object, else None."""
    return text.removeprefix(LOST) if text.startswith(LOST) else None


def parse_held_object(text: str) -> str | None:
    """Return the object's name if the marker ``text`` reports a new closing, else None."""
    if not text.startswith(TWIN) or text.startswith(ABOUT_HAND):
        return None
    return text.removeprefix(TWIN)


def concerns_hand(text: str) -> bool:
    return text.startswith(ABOUT_HAND)
