"""Registry of hands. To add a hand, write one file and add one line here."""

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
    """Return a hand that is not open yet. It runs in a separate process if its class says so.

    Parameters
    ----------
    kind
        Class of the hand.
    port
        Port that the hand is connected to, for hands that need one.
    source
        Source that drives the hand, already opened, for hands that need one. Keep it open as long
        as the hand.

    Raises
    ------
    InputError
        The port, the source or a package is missing.
    """
    made: Callable[[Any], Hand] = kind
    with HANDS.calling(kind.name):
        if kind.of_source is not None:
            if source is None:
                raise InputError(
                    f"the hand {kind.name!r} needs a source, which is missing: open the hand's "
                    "source and pass it"
                )
            return made(source)
        return SeparateHand(kind, port) if kind.separate else made(port)


def find_hand(hand: object) -> type[Hand] | Hand:
    """Return the class of hands with a name, or the hand itself, without its wrapper.

    Raises
    ------
    InputError
        No hand has that name, or the value is neither a name nor a hand.
    """
    if isinstance(hand, str):
        return HANDS.find(hand)
    if not isinstance(hand, Hand):
        raise InputError(
            f"{hand!r} is no hand: give a name, or an instance of firstcontact.grasp.Hand",
            parameter="hand",
        )
    return hand._hand if isinstance(hand, SafeHand) else hand


def open_hand(
    hand: str | Hand, port: str | None = None, *, source: object = None, silence: float = 1.0
) -> SafeHand:
    """Return a hand with a watchdog. Open it with ``with``.

    Parameters
    ----------
    hand
        Name in :data:`HANDS`, or a hand that is not open yet.
    port, source
        As in :func:`make_hand`. A hand that exists already uses neither.
    silence
        Time without a call from the program after which the hand is released, s.

    Raises
    ------
    InputError
        No hand has that name, its port, source or package is missing, or ``silence`` is not above
        0.
    """
    if isinstance(hand, SafeHand):
        return hand
    made = hand if isinstance(hand, Hand) else make_hand(HANDS.find(hand), port, source)
    return SafeHand(made, silence=silence)
