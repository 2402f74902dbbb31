"""What the twin and its host say to each other in orders and markers.

Orders go over the wire in frames of their own. A marker is never one, whatever it says: its
text may come from anybody.
"""

from __future__ import annotations

import re
from math import isfinite

from firstcontact.core import Command, InputError

#: How the twin begins all that it says.
TWIN = "twin: "
#: How the host begins an order to the hand, and one that says what it is to take.
HAND = "hand:"
OBJECT = "object:"
#: How the twin begins the answer to an order that it obeys.
TOLD = f"{TWIN}told "
#: How the twin begins what it says about the hand, and not about an object.
ABOUT_HAND = (f"{TWIN}peak ", f"{TWIN}hand ", TOLD, f"{TWIN}lost ")
#: How it answered once, without its name; recordings hold such markers.
_ANSWERED = re.compile(rf"{HAND} (release|-?\d+\.\d{{4}} -?\d+\.\d{{3}})")


def order_text(order: Command | None) -> str:
    """The order for a command, or for a release where there is none."""
    return f"{HAND} release" if order is None else f"{HAND} {order.speed:.4f} {order.force:.3f}"


def object_text(name: str) -> str:
    """The order to take only this object, from the next closing on."""
    return f"{OBJECT} {name}"


def read_order(text: str) -> Command | None:
    """The command in an order that begins with :data:`HAND`; None for a release.

    Raises
    ------
    InputError
        It is neither.
    """
    words = text.removeprefix(HAND).split()
    if words == ["release"]:
        return None
    try:
        speed, force = (float(word) for word in words)
    except ValueError:
        speed = force = float("nan")
    if not (isfinite(speed) and isfinite(force)):
        raise InputError("use a speed in m/s and a force in N, or release")
    return Command(speed, force)


def peak_text(peak: float) -> str:
    """How the twin says with what force, N, a closing squeezed at most."""
    return f"{ABOUT_HAND[0]}{peak:.1f} N"


def lost_text(how: str) -> str:
    """How the twin says that a closing has dropped or broken what it closed on."""
    return f"{ABOUT_HAND[3]}{how}"


def lost_object(text: str) -> str | None:
    """What the twin says that became of an object that was not held: "dropped" or "broken"."""
    return text.removeprefix(ABOUT_HAND[3]) if text.startswith(ABOUT_HAND[3]) else None


def held_object(text: str) -> str | None:
    """What the twin says that it closes on; None where a marker says something else."""
    if not text.startswith(TWIN) or text.startswith(ABOUT_HAND):
        return None
    return text.removeprefix(TWIN)


def concerns_hand(text: str) -> bool:
    """Whether a marker is what the twin says about the hand, or the answer to an order."""
    return text.startswith(ABOUT_HAND) or _ANSWERED.fullmatch(text) is not None
