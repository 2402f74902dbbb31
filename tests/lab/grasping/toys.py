"""Artificial picks and rows of a grasp study, with known numbers."""

import numpy as np

from firstcontact.core.physics import GRAVITY
from firstcontact.testing import make_estimate
from firstcontact_lab.grasping.picks import Pick
from firstcontact_lab.grasping.table import (
    DETECTION,
    LIFTS,
    ApproachOutcomes,
    ClosingGrid,
    ClosingTable,
)

HOW = ClosingGrid((0.10,), (1.0, 2.0, 4.0, 8.0), (2.0,))
#: Kind, force that just holds it, N, and force that damages it, N.
THINGS = {
    "raspberry": (0.1, 3.0), "silken tofu, 4 cm cube": (0.5, 3.0), "sponge, dry": (0.3, np.inf),
    "quail egg": (0.5, 20.0), "soup can": (6.0, np.inf), "wood block": (6.0, np.inf),
    "wrench": (5.0, np.inf), "hammer, at its handle": (5.0, np.inf),
}  # fmt: skip
SHORE = {"raspberry": 5.0, "silken tofu, 4 cm cube": 3.0, "sponge, dry": 3.0}


def branch(kind: str, hand: int, specimen: int = 1) -> ApproachOutcomes:
    """Return a pick with each final force. The hand obeys commands; its reflex holds with 9 N."""
    holds, limit = THINGS[kind]
    forces = np.array(HOW.forces)
    slips = forces < holds
    shape = (len(LIFTS), len(DETECTION), 1, len(forces))
    shore = SHORE.get(kind, 75.0)
    return ApproachOutcomes(
        Pick(kind, hand, specimen), 0.10, 2 * holds * 0.5 / GRAVITY, 0.5, limit,
        make_estimate(shore, shore - 5, shore + 5, 0.01), (), 0.02,
        forces, 2 * forces,
        np.broadcast_to(np.where(slips, 9.0, np.nan), shape).copy(),
        np.broadcast_to(np.where(slips, 0.0, np.nan), shape).copy(),
    )  # fmt: skip


def table(hands: tuple[int, ...]) -> ClosingTable:
    """Return a table of picks of all objects by these hands."""
    return ClosingTable.from_branches(
        [branch(kind, hand) for kind in THINGS for hand in hands], HOW
    )
