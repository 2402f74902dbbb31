"""Household objects to pick up, from raspberry to hammer, and their specimens.

Every number has a source or is marked as an estimate, in ``household.csv`` and
``docs/reference/twin-parameters.md``.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from io import StringIO
from typing import Any

import numpy as np

from firstcontact.core import ArgumentError, Role
from firstcontact.core.physics import gent_modulus
from firstcontact.twin.draw import Condition, draw_specimen, generator
from firstcontact.twin.mechanics import ObjectParameters
from firstcontact.twin.objects import OBJECTS, ORANGE_LOSS, Fragility, TwinObject, slow_share

#: Entry in place of a source if the number is an estimate.
ESTIMATE = "estimate"
#: Mass below which an object lies loosely, kg.
LIGHT = 0.02
#: Stiffness (N/m) and damping (N s/m) of the support: of light objects, which lie loosely, and of
#: all others.
LOOSE_HOLD = (20.0, 0.2)
HOLD = (60.0, 0.8)
#: Largest deviation of a specimen, in standard deviations.
MOST = 2.5


@dataclass(frozen=True, slots=True)
class Quantity:
    """Number in SI units with its source."""

    value: float
    source: str = ESTIMATE

    @property
    def estimated(self) -> bool:
        return self.source == ESTIMATE


@dataclass(frozen=True, slots=True)
class HouseholdNumbers:
    """Physical quantities of one type of household object, in SI units."""

    shore_a: Quantity
    mass: Quantity
    friction: Quantity
    #: Contact force that damages 63 of 100 specimens, N; None if this hand cannot do so.
    limit: Quantity | None
    weibull: Quantity | None
    #: Radius of curvature at the contact, m; None for flat objects.
    radius: Quantity | None
    thickness: Quantity
    #: Stiffness between the two contacts, N/m. A round object without it is as stiff as a column of
    #: its cross-section.
    bulk: Quantity | None
    loss: Quantity


@dataclass(frozen=True, slots=True)
class SpecimenScatter:
    """Standard deviations of ln(modulus), ln(mass) and friction between specimens."""

    modulus: float
    mass: float
    friction: float


#: Scatter of specimens by origin of the kind. All values are assumed.
SCATTER = {
    "grown": SpecimenScatter(modulus=0.15, mass=0.15, friction=0.05),
    "made": SpecimenScatter(modulus=0.06, mass=0.03, friction=0.05),
}


@dataclass(frozen=True, slots=True)
class HouseholdObject:
    """Kind of household object, and its group by hardness and robustness ("soft fragile")."""

    name: str
    group: str
    origin: str
    numbers: HouseholdNumbers

    @property
    def shore_a(self) -> float:
        return self.numbers.shore_a.value

    @property
    def scatter(self) -> SpecimenScatter:
        return SCATTER[self.origin]

    @property
    def kind(self) -> TwinObject:
        """Typical object of this kind, as the twin simulates it. Specimens scatter around it."""
        n = self.numbers
        mass, loss, modulus = n.mass.value, n.loss.value, gent_modulus(n.shore_a.value)
        flat = ObjectParameters().radius
        radius = flat if n.radius is None else n.radius.value
        if n.bulk is not None:
            bulk = n.bulk.value
        else:
            bulk = modulus * (math.pi * radius**2) / n.thickness.value
        hold, damping = LOOSE_HOLD if mass < LIGHT else HOLD
        slow = slow_share(min(loss, ORANGE_LOSS)) if self.origin == "grown" else 0.0
        nominal = ObjectParameters.solid(n.shore_a.value, mass, bulk, loss, slow)._replace(
            radius=radius, clamp_stiffness=hold, clamp_damping=damping
        )
        fragility = None
        if n.limit is not None and n.weibull is not None:
            fragility = Fragility(n.limit.value, n.weibull.value)
        return TwinObject(
            self.name, n.shore_a.value, Role.TEST, nominal, self.scatter.modulus,
            n.friction.value, fragility,
        )  # fmt: skip


def _numbers(row: Mapping[str, str]) -> HouseholdNumbers:
    quantities: dict[str, Any] = {
        field.name: Quantity(float(row[field.name]), row[f"{field.name}_from"])
        if row[field.name]
        else None
        for field in fields(HouseholdNumbers)
    }
    return HouseholdNumbers(**quantities)


def read_table(name: str) -> list[dict[str, str]]:
    """Return the rows of a CSV table in this folder. ``name`` is its file name."""
    return list(csv.DictReader(StringIO(files(__package__).joinpath(name).read_text("utf-8"))))


#: Household objects in the order of the file: soft ones first.
HOUSEHOLD = tuple(
    HouseholdObject(row["name"], row["group"], row["origin"], _numbers(row))
    for row in read_table("household.csv")
)
_BY_NAME = {item.name: item for item in HOUSEHOLD}


def household_named(name: str) -> HouseholdObject:
    if name not in _BY_NAME:
        names = ", ".join(_BY_NAME)
        raise ArgumentError(f"object {name!r} is not a household object: use one of {names}")
    return _BY_NAME[name]


def draw_household_specimen(
    seed: int, condition: Condition, item: HouseholdObject, number: int
) -> TwinObject:
    """Return specimen ``number`` with random modulus, mass, friction and breaking force.

    They depend only on the seed, the condition, the object and ``number``.
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
    """Return the object with this name from all :data:`OBJECT_SETS`.

    Raises
    ------
    InputError
        There is no such object.
    """
    by_name: dict[str, TwinObject | HouseholdObject] = {**OBJECTS, **_BY_NAME}
    if name not in by_name:
        raise ArgumentError(f"object {name!r} is not known: use one of {', '.join(by_name)}")
    return by_name[name]
