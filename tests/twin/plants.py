"""Plants for the tests of the twin's hand."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray
from pinches import drawn

from firstcontact.core import Command
from firstcontact.twin import Drive, GraspPlant, TwinObject, VelostatParameters

COMMANDS = st.builds(Command, st.floats(-0.5, 0.5), st.floats(-1.0, 30.0))


def plant(
    kind: TwinObject, number: int = 0, drive: Drive | None = None,
    velostat: VelostatParameters | None = None,
) -> GraspPlant:  # fmt: skip
    return GraspPlant(drawn(kind, number), drive or Drive(), kind, velostat)


def closed(hand: GraspPlant, command: Command | None = None, piece: int = 50) -> NDArray[np.int16]:
    if command is not None:
        hand.command(command)
    blocks = []
    while not hand.ended:
        blocks.append(hand.advance(piece))
    return np.concatenate(blocks)
