"""Twin sets of single contacts on which learners are compared: two hands, blocks and objects.

Specimens and hands are drawn from the set's seed alone, so sets of several seeds are several
draws of everything that a rig's owner cannot choose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from firstcontact.anytime import Touches, touches_of
from firstcontact.anytime.touches import BEFORE, LONGEST
from firstcontact.core import Contact, Dataset, Pinch
from firstcontact.core.layout import FINGERTIP_RATE
from firstcontact.stiffness.spec import Values
from firstcontact.twin.conditions import Condition, condition
from firstcontact.twin.draw import draw_pinch
from firstcontact.twin.pinch import excerpt, simulate_pinch
from firstcontact.twin.plan import PlannedSession, plan_sessions

#: Pinches of each block and of each unseen object, in a set of the usual size.
BLOCKS, OBJECTS = 40, 20
#: Block pinches that are known of the second hand, of each level: 30 of five levels.
OTHER_HAND = 6
#: How late contacts are placed, samples: mean and standard deviation, about what the detectors
#: do on the twin, and the most.
PLACED, FARTHEST = (1.5, 1.5), 8
#: Added to the seed for the second hand.
_OTHER = 500_000


@dataclass(frozen=True, slots=True, eq=False)
class Labelled:
    """Contacts with what is known of them; all arrays have shape (n,)."""

    touches: Touches
    shore_a: Values
    sessions: NDArray[np.str_]
    specimens: NDArray[np.str_]

    def __len__(self) -> int:
        return len(self.touches)

    def take(self, which: NDArray[np.intp] | NDArray[np.bool_]) -> Labelled:
        """Those at these positions, or where a mask is true."""
        return Labelled(
            self.touches.take(which),
            self.shore_a[which],
            self.sessions[which],
            self.specimens[which],
        )


@dataclass(frozen=True, slots=True, eq=False)
class RigSet:
    """What one draw of specimens and hands gives.

    Parameters
    ----------
    name
        Of condition and seed.
    blocks, objects
        Of the hand at home: blocks to learn from, and objects of role ``test``.
    other_blocks, other_objects
        The same of another hand, few blocks.
    """

    name: str
    blocks: Labelled
    objects: Labelled
    other_blocks: Labelled
    other_objects: Labelled


def rig_set(name: str, seed: int, blocks: int = BLOCKS, objects: int = OBJECTS) -> RigSet:
    """Simulate a set; the same condition, seed and size give the same numbers.

    Parameters
    ----------
    name
        Of the twin's condition.
    seed
        Of specimens, hands and pinches.
    blocks, objects
        Pinches of each block and of each unseen object.

    Raises
    ------
    InputError
        No condition has that name.
    """
    c = condition(name)
    home = _contacts(c, plan_sessions(c, blocks, objects, seed), seed)
    known = min(OTHER_HAND, blocks)
    other = _contacts(c, plan_sessions(c, known, objects, seed), seed + _OTHER)
    return RigSet(f"{name}, seed {seed}", *home, *other)


def _contacts(
    c: Condition, sessions: tuple[PlannedSession, ...], hand: int
) -> tuple[Labelled, Labelled]:
    """Blocks and objects of these sessions, pinched by the hand of this seed."""
    pinches: list[Pinch] = []
    contacts: list[Contact | None] = []
    margin = (FARTHEST + 2) / FINGERTIP_RATE
    for session in sessions:
        for planned in session.pinches:
            key = planned.label.specimen + f" {planned.number}"
            draw = draw_pinch(hand, c, session.name, planned.specimen, key)
            part = excerpt(draw, BEFORE + margin)
            pinch = simulate_pinch(part, planned.label, duration=BEFORE + LONGEST + 2 * margin)
            late = np.clip(np.rint(draw.rng.normal(*PLACED)), -FARTHEST, FARTHEST)
            first = pinch.first
            pinches.append(pinch)
            contacts.append(first and replace(first, sample=first.sample + int(late)))
    dataset = Dataset(tuple(pinches), "twin")
    touches, which = touches_of(dataset, contacts)
    whole = Labelled(
        touches, dataset.shore_a[which], dataset.sessions[which], dataset.specimens[which]
    )
    test = dataset.test[which]
    return whole.take(~test), whole.take(test)
