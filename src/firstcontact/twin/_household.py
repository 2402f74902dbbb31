"""The household: things that people pick up, from raspberry to hammer, and their specimens.

Every number has its source or is called an estimate, in ``household.csv`` and
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

#: No specimen is more standard deviations off.
MOST = 2.5


def _text(file: str) -> str:
    return files("firstcontact.twin").joinpath(file).read_text(encoding="utf-8")


#: Whom numbers are from, by key.
HOUSEHOLD_SOURCES = read_sources(_text("household_sources.csv"), "household_sources.csv")
#: In the order of the file: soft things first.
HOUSEHOLD: tuple[HouseholdObject, ...] = read_household(
    _text("household.csv"), HOUSEHOLD_SOURCES, "household.csv"
)


def household_named(name: str) -> HouseholdObject:
    """The kind of that name.

    Raises
    ------
    InputError
        There is none.
    """
    for one in HOUSEHOLD:
        if one.name == name:
            return one
    names = ", ".join(one.name for one in HOUSEHOLD)
    raise InputError(f"object {name!r} is not of the household: use one of {names}")


def draw_household_specimen(
    seed: int, condition: Condition, thing: HouseholdObject, number: int
) -> TwinObject:
    """The ``number``-th specimen of a kind: its own modulus, mass, friction and limit.

    The modulus is drawn as that of every specimen, its scatter widened by the condition. Mass
    and friction scatter as :data:`firstcontact.twin._household_object.SCATTER` says. The limit is
    Weibull's, and the specimen has this one limit in every pinch.
    """
    kind = thing.kind
    drawn = draw_specimen(seed, condition, kind, number)
    rng = generator(seed, condition.name, "household specimen", kind.name, number)
    mass, friction = np.clip(rng.standard_normal(2), -MOST, MOST)
    limit = None if kind.fragility is None else kind.fragility.draw(rng)
    face = kind.nominal.face_mass * math.exp(thing.scatter.mass * float(mass))
    return replace(
        drawn,
        nominal=drawn.nominal._replace(face_mass=face),
        friction=max(kind.friction + thing.scatter.friction * float(friction), 0.05),
        # A Weibull without scatter: a specimen bears the same each time.
        fragility=None if limit is None else Fragility(limit, math.inf),
    )


#: What a running hand may pick from, by name.
OBJECT_SETS: Mapping[str, tuple[TwinObject | HouseholdObject, ...]] = {
    "paper": tuple(OBJECTS.values()),
    "household": HOUSEHOLD,
}


def thing_named(name: str) -> TwinObject | HouseholdObject:
    """The object of that name, of any set.

    Raises
    ------
    InputError
        There is none.
    """
    for things in OBJECT_SETS.values():
        for thing in things:
            if thing.name == name:
                return thing
    names = ", ".join(t.name for things in OBJECT_SETS.values() for t in things)
    raise InputError(f"object {name!r} is not known: use one of {names}")
