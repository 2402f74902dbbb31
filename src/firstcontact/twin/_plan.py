"""Plan of a simulated set: its sessions, objects and their order."""

from __future__ import annotations

from dataclasses import dataclass

from firstcontact.core import Label, Role
from firstcontact.twin._conditions import Condition
from firstcontact.twin._draw import draw_specimen, generator
from firstcontact.twin._objects import BLOCKS, EVERYDAY_OBJECTS, TwinObject

#: Number of sessions of the blocks, and of the unseen objects.
BLOCK_SESSIONS = 10
OBJECT_SESSIONS = 2


@dataclass(frozen=True, slots=True)
class PlannedPinch:
    """Planned pinch: a specimen, its label, and its number in the session."""

    specimen: TwinObject
    label: Label
    number: int


@dataclass(frozen=True, slots=True)
class PlannedSession:
    """Planned session: its name, and its pinches in their order."""

    name: str
    pinches: tuple[PlannedPinch, ...]


def plan_sessions(
    condition: Condition, pinches_per_block: int, pinches_per_object: int, seed: int
) -> tuple[PlannedSession, ...]:
    """Return the planned sessions of a simulated set, with flat blocks or other objects."""
    blocks = _sessions(condition, "blocks", BLOCKS, pinches_per_block, BLOCK_SESSIONS, seed)
    objects = _sessions(
        condition, "objects", EVERYDAY_OBJECTS, pinches_per_object, OBJECT_SESSIONS, seed
    )
    return (*blocks, *objects)


def _sessions(
    condition: Condition,
    group: str,
    kinds: tuple[TwinObject, ...],
    each: int,
    sessions: int,
    seed: int,
) -> list[PlannedSession]:
    out = []
    for s in range(min(sessions, each)):
        name = f"{group}-{s + 1:02d}"
        pinches = []
        for kind in kinds:
            for k in range(s, each, sessions):
                pinches.append(planned_pinch(seed, condition, kind, name, k // sessions, k))
        order = generator(seed, condition.name, "order", name).permutation(len(pinches))
        out.append(PlannedSession(name, tuple(pinches[i] for i in order)))
    return out


def planned_pinch(
    seed: int, condition: Condition, kind: TwinObject, session: str, copy: int, number: int
) -> PlannedPinch:
    """Return one planned pinch of an object. ``copy`` numbers the specimens, and wraps around."""
    copies = condition.specimens_per_block if kind.role is Role.TRAIN else 1
    copy %= copies
    one = draw_specimen(seed, condition, kind, copy)
    mark = f"{kind.name} #{copy + 1}" if copies > 1 else kind.name
    label = Label(kind.name, kind.shore_a, None, mark, session, kind.role)
    return PlannedPinch(one, label, number)
