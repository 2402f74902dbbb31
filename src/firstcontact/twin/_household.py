"""Household objects to pick up, from raspberry to hammer, and their specimens.

Every number has a source or is marked as an estimate, in ``household.csv`` and
``docs/reference/household.md``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from importlib.resources import files

import numpy as np

from firstcontact.core import InputError
from firstcontact.twin._conditions import Condition
from firstcontact.twin._draw import draw_specimen, generator
from firstcontact.twin._household_file import read_household, read_sources
from firstcontact.twin._household_object import HouseholdObject
from firstcontact.twin._objects import OBJECTS, Fragility, TwinObject

#: Largest deviation of a specimen, in standard deviations.
MOST = 2.5


def _text(file: str) -> str:
    return files("firstcontact.twin").joinpath(file).read_text(encoding="utf-8")


#: Sources of the numbers, by key.
HOUSEHOLD_SOURCES = read_sources(_text("household_sources.csv"), "household_sources.csv")
#: Household objects in the order of the file: soft ones first.
HOUSEHOLD: tuple[HouseholdObject, ...] = read_household(
    _text("household.csv"), HOUSEHOLD_SOURCES, "household.csv"
)


def household_named(name: str) -> HouseholdObject:
    """Return the household object with this name.

    Raises
    ------
    InputError
        There is no such object.
    """
    for one in HOUSEHOLD:
        if one.name == name:
            return one
    names = ", ".join(one.name for one in HOUSEHOLD)
    raise InputError(f"object {name!r} is not a household object: use one of {names}")


def draw_household_specimen(
    seed: int, condition: Condition, item: HouseholdObject, number: int
) -> TwinObject:
    """Draw specimen ``number``: its modulus, mass, friction and breaking force.

    The modulus scatters as the condition states, as for all objects. Mass and friction scatter as
    :data:`firstcontact.twin._household_object.SCATTER` states. The breaking force is drawn from a
    Weibull distribution, and stays the same in every pinch of the specimen.
    """
    kind = item.kind
    drawn = draw_specimen(seed, condition, kind, number)
    rng = generator(seed, condition.name, "household specimen", kind.name, number)
    mass, friction = np.clip(rng.standard_normal(2), -MOST, MOST)
    limit = None if kind.fragility is None else kind.fragility.draw(rng)
    face = kind.nominal.face_mass * math.exp(item.scatter.mass * float(mass))
    return replace(
        drawn,
        nominal=drawn.nominal._replace(face_mass=face),
        friction=max(kind.friction + item.scatter.friction * float(friction), 0.05),
        # A Weibull distribution without scatter: a specimen has the same breaking force each time.
        fragility=None if limit is None else Fragility(limit, math.inf),
    )


#: Sets of objects for a running hand, by name.
OBJECT_SETS: Mapping[str, tuple[TwinObject | HouseholdObject, ...]] = {
    "paper": tuple(OBJECTS.values()),
    "household": HOUSEHOLD,
}


def find_object(name: str) -> TwinObject | HouseholdObject:
    """Return the object with this name, from any of the :data:`OBJECT_SETS`.

    Raises
    ------
    InputError
        There is no such object.
    """
    for objects in OBJECT_SETS.values():
        for one in objects:
            if one.name == name:
                return one
    names = ", ".join(t.name for objects in OBJECT_SETS.values() for t in objects)
    raise InputError(f"object {name!r} is not known: use one of {names}")
