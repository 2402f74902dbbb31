"""All hands by name. A new hand is one file and one line here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from firstcontact.core import InputError
from firstcontact.grasp.ability import AbilityHand
from firstcontact.grasp.ability_package import SIMULATED
from firstcontact.grasp.hand import Hand
from firstcontact.grasp.printing import PrintHand
from firstcontact.grasp.safe import SafeHand
from firstcontact.grasp.separate import SeparateHand


@dataclass(frozen=True, slots=True)
class HandKind:
    """How to make a hand.

    Parameters
    ----------
    make
        From a port's name, or None, to a hand that is not open yet.
    rehearsal
        The port under which it works without hardware, for tests and dry runs.
    """

    make: Callable[[str | None], Hand]
    rehearsal: str | None = None


HANDS: dict[str, HandKind] = {
    PrintHand.name: HandKind(lambda port: PrintHand()),
    AbilityHand.name: HandKind(partial(SeparateHand, AbilityHand), rehearsal=SIMULATED),
}


def open_hand(name: str, port: str | None = None, *, silence: float = 1.0) -> SafeHand:
    """A hand made safe, to be entered by ``with``.

    Parameters
    ----------
    name
        One of :data:`HANDS`.
    port
        Where it is connected, for hands that need it.
    silence
        Time without a word of the program after which it is released, s.

    Raises
    ------
    InputError
        There is none of that name, or it needs something that is missing.
    """
    if name not in HANDS:
        raise InputError(f"no hand is called {name!r}: choose one of {', '.join(HANDS)}")
    return SafeHand(HANDS[name].make(port), silence=silence)
