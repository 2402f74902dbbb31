"""Pinches for the tests of the twin."""

import math

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from firstcontact.core import Command, Label, Pinch
from firstcontact.twin import CONDITIONS, TwinObject, draw_pinch, simulate_pinch
from firstcontact.twin.draw import Condition, PinchDraw, draw_specimen
from firstcontact.twin.drive import Drive
from firstcontact.twin.household import household_named
from firstcontact.twin.mechanics import (
    FINGER_STATES,
    OUTPUTS,
    STATES,
    FingerParameters,
    ObjectParameters,
    Piece,
    contact_stiffness,
    integrate_all,
)
from firstcontact.twin.plant import GraspPlant

PAPER_RIG, EVERYDAY = CONDITIONS["paper-rig"], CONDITIONS["everyday"]

#: Objects that break.
BRITTLE = tuple(household_named(n).kind for n in ("quail egg", "potato crisp", "raspberry"))
SEED = 20
Fingers = tuple[FingerParameters, FingerParameters]


def drawn(kind: TwinObject, number: int = 0, condition: Condition = PAPER_RIG) -> PinchDraw:
    """Return a new draw of one pinch, because simulation uses up the random numbers of a draw."""
    specimen = draw_specimen(SEED, condition, kind, 0)
    return draw_pinch(SEED, condition, f"session {number % 4}", specimen, number)


def simulated(kind: TwinObject, number: int = 0, condition: Condition = PAPER_RIG) -> Pinch:
    """Return one pinch as the device would send it."""
    return simulate_pinch(
        drawn(kind, number, condition), Label(kind.name, kind.shore_a, role=kind.role)
    )


def moving(fingers: Fingers) -> NDArray[np.float64]:
    """Return the state of two fingers, each at its own closing speed."""
    x = np.zeros(STATES)
    for f, p in enumerate(fingers):
        x[f * FINGER_STATES + 1 : f * FINGER_STATES + 8 : 2] = p.speed
    return x


def integrated(
    fingers: Fingers, o: ObjectParameters, touch: tuple[float, float] | NDArray[np.float64],
    times: NDArray[np.float64], x: NDArray[np.float64], gap: NDArray[np.float64] | None = None,
    substeps: int = 1, back_damping: float = 0.0,
) -> NDArray[np.float64]:  # fmt: skip
    """Integrate a motion without noise. Change ``x`` and ``gap`` in place."""
    out = np.empty((times.size, 2, OUTPUTS))
    piece = Piece(
        *fingers, o, np.array([contact_stiffness(p, o) for p in fingers]), np.array(touch), times,
        np.zeros((2, 2)), 1.0, substeps, np.array([[p.speed for p in fingers]]),
        fingers[0].drive_force, back_damping, 0.0, math.inf, math.inf, 1, x,
        np.full(2, np.nan) if gap is None else gap, np.full(2, np.nan), out,
    )  # fmt: skip
    assert integrate_all([piece]) == [times.size]
    return out


COMMANDS = st.builds(Command, st.floats(-0.5, 0.5), st.floats(-1.0, 30.0))


def plant(kind: TwinObject, number: int = 0, drive: Drive | None = None) -> GraspPlant:
    return GraspPlant(drawn(kind, number), drive or Drive(), kind)


def closed(hand: GraspPlant, command: Command | None = None, piece: int = 50) -> NDArray[np.int16]:
    if command is not None:
        hand.command(command)
    blocks = []
    while not hand.ended:
        blocks.append(hand.advance(piece))
    return np.concatenate(blocks)
