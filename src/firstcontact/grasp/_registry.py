"""All hands by name. A new hand is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from firstcontact.core import InputError, Registry
from firstcontact.grasp._hand import Hand
from firstcontact.grasp._safe import SafeHand
from firstcontact.grasp._separate import SeparateHand

HANDS: Registry[type[Hand]] = Registry(
    "hand",
    "firstcontact.hands",
    {
        "print": "firstcontact.grasp._printing:PrintHand",
        "twin": "firstcontact.streaming._twin_hand:TwinHand",
        "ability": "firstcontact.grasp._ability:AbilityHand",
    },
    base="firstcontact.grasp._hand:Hand",
)


def make_hand(kind: type[Hand], port: str | None = None, source: object = None) -> Hand:
    """A hand that is not open yet, in a process of its own if it is to have one.

    Parameters
    ----------
    kind
        A class of hands.
    port
        Where it is connected, for hands that need it.
    source
        Over which it is driven, for hands that are; open when the hand is and as long.

    Raises
    ------
    InputError
        It needs something that is missing.
    """
    made: Callable[[Any], Hand] = kind
    with HANDS.calling(kind.name):
        if kind.of_source is not None:
            if source is None:
                raise InputError(
                    f"the hand {kind.name!r} needs its source: open it, and pass it on"
                )
            return made(source)
        return SeparateHand(kind, port) if kind.separate else made(port)


def open_hand(
    name: str, port: str | None = None, *, source: object = None, silence: float = 1.0
) -> SafeHand:
    """A hand made safe, to be entered by ``with``.

    Parameters
    ----------
    name
        One of :data:`HANDS`.
    port, source
        As in :func:`make_hand`.
    silence
        Time without a word of the program after which it is released, s.

    Raises
    ------
    InputError
        There is none of that name, or it needs something that is missing.
    """
    return SafeHand(make_hand(HANDS.find(name), port, source), silence=silence)
