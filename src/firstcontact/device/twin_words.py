"""What the twin and its host say to each other in marks and markers."""

from __future__ import annotations

from math import isfinite

from firstcontact.core import Command, InputError

#: How the twin begins all that it says.
TWIN = "twin: "
#: How the host begins an order to the hand.
HAND = "hand:"
#: How the twin begins what it says about the hand, and not about an object.
ABOUT_HAND = (f"{TWIN}peak ", f"{TWIN}hand ")


def order_text(order: Command | None) -> str:
    """The mark for a command, or for a release where there is none."""
    return f"{HAND} release" if order is None else f"{HAND} {order.speed:.4f} {order.force:.3f}"


def read_order(text: str) -> Command | None:
    """The command in a mark that begins with :data:`HAND`; None for a release.

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
        said = " ".join(words)
        raise InputError(
            f"hand order {said!r} is none: use a speed in m/s and a force in N, or release"
        )
    return Command(speed, force)


def peak_text(peak: float) -> str:
    """How the twin says with what force, N, a closing squeezed at most."""
    return f"{ABOUT_HAND[0]}{peak:.1f} N"


def held_object(text: str) -> str | None:
    """What the twin says that it closes on; None where a marker says something else."""
    if not text.startswith(TWIN) or text.startswith(ABOUT_HAND):
        return None
    return text.removeprefix(TWIN)


def concerns_hand(text: str) -> bool:
    """Whether a marker is an order to the hand, or what the twin says about it."""
    return text.startswith((HAND, *ABOUT_HAND))
