"""Pinches for the tests of the twin."""

from __future__ import annotations

from firstcontact.core.pinch import Label, Pinch
from firstcontact.twin.conditions import PAPER_RIG, Condition
from firstcontact.twin.draw import PinchDraw, draw_pinch, draw_specimen
from firstcontact.twin.objects import TwinObject
from firstcontact.twin.pinch import simulate_pinch

SEED = 20


def drawn(kind: TwinObject, number: int = 0, condition: Condition = PAPER_RIG) -> PinchDraw:
    """The chance of one pinch; drawn anew each time, since simulating uses it up."""
    specimen = draw_specimen(SEED, condition, kind, 0)
    return draw_pinch(SEED, condition, f"session {number % 4}", specimen, number)


def simulated(kind: TwinObject, number: int = 0, condition: Condition = PAPER_RIG) -> Pinch:
    """One pinch as the device would send it."""
    return simulate_pinch(
        drawn(kind, number, condition), Label(kind.name, kind.shore_a, role=kind.role)
    )
