"""Simulated pinches of blocks and objects by two hands, for the study part ``generalise``.

The seeds are used only here. Only the time around the contacts is simulated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import Contact, Dataset, Label, Pinch
from firstcontact.models import Touches
from firstcontact.models.labelled_data import DURATION, LabelledWindows, labelled_windows
from firstcontact.twin import BLOCKS, draw_pinch
from firstcontact.twin.draw import Condition, PinchDraw, draw_specimen, generator
from firstcontact.twin.mechanics import contact_stiffness
from firstcontact.twin.objects import EVERYDAY_OBJECTS
from firstcontact.twin.pinch import PinchJob, excerpt, simulate_pinches

Values = NDArray[np.float64]
#: Simulated time of a pinch, s: before its first contact, and in total.
BEFORE, LENGTH = 0.045, 0.070
#: Value added to the seed of a set for the other hand.
OTHER_HAND = 1_000_000


#: Radius from which an object counts as flat, m.
FLAT = 1.0


class PinchUse(StrEnum):
    """Purpose of a simulated pinch in a comparison: which pinches to learn from, and to predict."""

    #: Blocks for conditioning, and blocks of other sessions.
    BLOCKS = "blocks"
    HELD = "held_blocks"
    #: Objects that no estimator is trained on.
    OBJECTS = "objects"
    #: Blocks and objects of another hand.
    OTHER_BLOCKS = "other_hand_blocks"
    OTHER_OBJECTS = "other_hand_objects"
    #: Other specimens of the same kinds of object, for the floor.
    KINDS = "kinds"


@dataclass(frozen=True, slots=True)
class Sizes:
    blocks: int = 40
    held_out: int = 10
    objects: int = 20
    other_blocks: int = 6
    kinds: int = 80


@dataclass(frozen=True, slots=True, eq=False)
class RigSet:
    windows: LabelledWindows
    touches: Touches
    uses: NDArray[np.str_]
    radii: Values
    moduli: Values
    stiffnesses: Values
    too_short: float

    def indices(self, use: PinchUse) -> NDArray[np.intp]:
        return np.flatnonzero(self.uses == use)


def rig_set(seed: int, condition: Condition, sizes: Sizes, late: Sequence[int]) -> RigSet:
    drawn = list(_planned(seed, condition, sizes))
    placed = generator(seed, condition.name, "placed")
    jobs = [PinchJob(excerpt(planned.draw, BEFORE), planned.label) for planned in drawn]
    pinches, contacts = [], []
    for pinch in simulate_pinches(jobs, LENGTH):
        pinches.append(pinch)
        contacts.append(_contact_later(pinch, int(placed.choice(late))))
    dataset = Dataset(tuple(pinches))
    windows = labelled_windows(dataset, contacts, DURATION, dataset.shore_a)
    touches, indices = Touches.cut(dataset, contacts)
    lasting = touches.answerable
    common = np.intersect1d(indices[lasting], windows.rows)
    chosen = [drawn[place] for place in common]
    radii = np.array([planned.draw.object.radius for planned in chosen])
    return RigSet(
        windows.take(np.isin(windows.rows, common)),
        touches.take(np.isin(indices, common)),
        np.array([planned.use.value for planned in chosen]),
        np.where(radii > FLAT, np.inf, radii),
        np.array([planned.draw.object.modulus for planned in chosen]),
        np.array([planned.stiffness for planned in chosen]),
        1.0 - float(lasting.mean()),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    use: PinchUse
    label: Label
    draw: PinchDraw

    @property
    def stiffness(self) -> float:
        first = self.draw.fingers[0 if self.draw.timing.first_is_index else 1]
        return contact_stiffness(first, self.draw.object)


def _planned(seed: int, condition: Condition, sizes: Sizes) -> Iterator[_Drawn]:
    copies = condition.specimens_per_block
    other = seed + OTHER_HAND
    for use, hand, kinds, each, sessions, first, specimens in (
        (PinchUse.BLOCKS, seed, BLOCKS, sizes.blocks, 8, 0, copies),
        (PinchUse.HELD, seed, BLOCKS, sizes.held_out, 2, 0, copies),
        (PinchUse.OBJECTS, seed, EVERYDAY_OBJECTS, sizes.objects, 2, 0, 1),
        (PinchUse.OTHER_BLOCKS, other, BLOCKS, sizes.other_blocks, 2, 0, copies),
        (PinchUse.OTHER_OBJECTS, other, EVERYDAY_OBJECTS, sizes.objects, 2, 0, 1),
        # Other specimens than those to predict, in separate sessions.
        (PinchUse.KINDS, seed, EVERYDAY_OBJECTS, sizes.kinds, 8, 1, 8),
    ):
        for kind in kinds:
            for number in range(each):
                session = f"{use.value}-{number % sessions + 1}"
                copy = first + number // sessions % specimens
                specimen = draw_specimen(seed, condition, kind, copy)
                yield _Drawn(
                    use,
                    Label(
                        kind.name,
                        kind.shore_a,
                        None,
                        f"{kind.name} #{copy}",
                        session,
                        kind.role,
                        kind.shape,
                    ),
                    draw_pinch(hand, condition, session, specimen, f"{kind.name} {number}"),
                )


def _contact_later(pinch: Pinch, late: int) -> Contact | None:
    """Return the first contact of a pinch, moved ``late`` samples later.

    Return None if there is no contact.
    """
    return None if pinch.first is None else replace(pinch.first, sample=pinch.first.sample + late)
