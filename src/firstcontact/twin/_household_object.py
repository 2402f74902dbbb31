"""Household objects: their numbers with sources, and the objects that the twin simulates."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from firstcontact.core import Role, gent_modulus
from firstcontact.twin._objects import Fragility, TwinObject
from firstcontact.twin._parameters import ObjectParameters

#: Entry in place of a source if the number is an estimate.
ESTIMATE = "estimate"
#: Radius of curvature of flat objects, m.
FLAT = ObjectParameters().radius
#: Mass below which an object lies loosely, kg.
LIGHT = 0.02
#: Stiffness (N/m) and damping (N s/m) of the support: of light objects, which lie loosely, and of
#: all others.
LOOSE_HOLD = (20.0, 0.2)
HOLD = (60.0, 0.8)


@dataclass(frozen=True, slots=True)
class Quantity:
    """Number with its source.

    Parameters
    ----------
    value
        Value in SI units or Shore A.
    source
        Key of the source, or "estimate".
    """

    value: float
    source: str = ESTIMATE

    @property
    def estimated(self) -> bool:
        """Return True if the number was not measured."""
        return self.source == ESTIMATE


@dataclass(frozen=True, slots=True)
class HouseholdNumbers:
    """Physical quantities of one type of household object.

    Parameters
    ----------
    shore_a
        Effective Shore A: the value of an elastomer with the same contact modulus.
    mass
        Mass, kg.
    friction
        Coefficient of friction against the pad's silicone.
    limit
        Contact force that damages 63 of 100 specimens, N; None if this hand cannot damage the
        object.
    weibull
        Weibull modulus of the damaging force; None without a limit.
    radius
        Radius of curvature at the contact, m; None for flat objects.
    thickness
        Thickness across the pinch, m.
    bulk
        Stiffness of the whole object between the two contacts, N/m. None for a round object: it is
        taken to be as stiff as a column of its cross-section.
    loss
        Loss factor of the material.
    """

    shore_a: Quantity
    mass: Quantity
    friction: Quantity
    limit: Quantity | None
    weibull: Quantity | None
    radius: Quantity | None
    thickness: Quantity
    bulk: Quantity | None
    loss: Quantity


#: Names of the quantities, in the order of the file.
QUANTITIES = tuple(field.name for field in fields(HouseholdNumbers))
#: Optional quantities.
OPTIONAL = ("limit", "weibull", "radius", "bulk")


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
    """Kind of household object."""

    name: str
    group: str
    origin: str
    numbers: HouseholdNumbers

    @property
    def shore_a(self) -> float:
        """Effective Shore A."""
        return self.numbers.shore_a.value

    @property
    def scatter(self) -> SpecimenScatter:
        """Scatter between specimens of the object."""
        return SCATTER[self.origin]

    @property
    def kind(self) -> TwinObject:
        """Object that the twin simulates, with nominal numbers. Specimens scatter around it."""
        n = self.numbers
        mass, loss = n.mass.value, n.loss.value
        modulus = gent_modulus(n.shore_a.value)
        bulk = self.bulk
        hold, damping = LOOSE_HOLD if mass < LIGHT else HOLD
        nominal = ObjectParameters(
            modulus=modulus,
            radius=FLAT if n.radius is None else n.radius.value,
            face_mass=mass / 2,
            bulk_stiffness=bulk,
            bulk_damping=loss * math.sqrt(bulk * mass / 4),
            clamp_stiffness=hold,
            clamp_damping=damping,
            arm_share=2 * loss,
            contact_loss=loss,
        )
        fragility = None
        if n.limit is not None and n.weibull is not None:
            fragility = Fragility(n.limit.value, n.weibull.value)
        return TwinObject(
            self.name, n.shore_a.value, Role.TEST, nominal, self.scatter.modulus,
            n.friction.value, fragility,
        )  # fmt: skip

    @property
    def bulk(self) -> float:
        """Stiffness of the whole object between the two contacts, N/m."""
        n = self.numbers
        if n.bulk is not None:
            return n.bulk.value
        if n.radius is None:
            raise ValueError(f"{self.name} is flat and has no bulk stiffness")
        area = math.pi * n.radius.value**2
        return gent_modulus(n.shore_a.value) * area / n.thickness.value
