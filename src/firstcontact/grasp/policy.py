"""What a grasp policy is: from what is known of a pinch to what the hand should do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from firstcontact.core import Command, Contact


@dataclass(frozen=True, slots=True)
class Stiffness:
    """An estimate as a policy sees it: one that the second finger has not overtaken.

    Parameters
    ----------
    value
        Shore A.
    low, high
        Bounds of the interval; equal to the value where the model has none.
    duration
        Of the window it was made from, s.
    """

    value: float
    low: float
    high: float
    duration: float


class Policy(Protocol):
    """Decides what a hand does in one closing after the other.

    Each method may answer with a command, which holds until the next, or with None
    to leave things as they are.
    """

    @property
    def name(self) -> str:
        """Under which it is registered and reported."""

    @property
    def deadline(self) -> float | None:
        """Time after the first contact by which it wants an estimate, s; None if it wants none."""

    def begin(self) -> Command:
        """A closing begins: how to close."""

    def touched(self, contact: Contact, first: bool) -> Command | None:
        """A finger touched; ``first`` says whether it is the first of this closing."""

    def estimated(self, stiffness: Stiffness) -> Command | None:
        """An estimate came."""

    def felt(self, volts: float, since: float | None) -> Command | None:
        """The loudest taxel is this far above its unloaded level, V, so long after the contact, s.

        Asked with every block of samples; ``since`` is None before the first contact.
        """

    def late(self) -> Command | None:
        """The deadline passed without an estimate: the declared fallback."""
