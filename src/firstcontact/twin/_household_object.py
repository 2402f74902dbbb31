"""One thing of a household: its numbers, where each is from, and what the twin makes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from firstcontact.core import Role, gent_modulus
from firstcontact.twin._objects import Fragility, TwinObject
from firstcontact.twin._parameters import ObjectParameters

#: Instead of a source, where a number is nobody's measurement.
ESTIMATE = "estimate"
#: Curvature radius of what is flat, m.
FLAT = ObjectParameters().radius
#: What is lighter lies loosely: its weight does not hold it, kg.
LIGHT = 0.02
#: Stiffness and damping of what holds it, N/m and N s/m: light things, and others.
LOOSE_HOLD = (20.0, 0.2)
HOLD = (60.0, 0.8)


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number and where it is from.

    Parameters
    ----------
    value
        In SI units or Shore A.
    source
        Key of a source, or "estimate".
    """

    value: float
    source: str = ESTIMATE

    @property
    def estimated(self) -> bool:
        """Whether it is nobody's measurement."""
        return self.source == ESTIMATE


@dataclass(frozen=True, slots=True)
class HouseholdNumbers:
    """What is known or assumed of a kind of thing.

    Parameters
    ----------
    shore_a
        Effective Shore A: of the elastomer whose contact modulus is the thing's.
    mass
        kg.
    friction
        Coefficient against the pad's silicone.
    limit
        Contact force at which 63 of 100 specimens are damaged, N; None where this hand
        damages none.
    weibull
        Weibull's modulus of the limit; None without a limit.
    radius
        Of the curvature where it is touched, m; None for what is flat.
    thickness
        Across the pinch, m.
    bulk
        Stiffness between the fingers behind both contacts, N/m; None for a round
        thing that is as stiff as a column of its own cross-section.
    loss
        Loss factor.
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
#: Those that need not be there.
OPTIONAL = ("limit", "weibull", "radius", "bulk")


@dataclass(frozen=True, slots=True)
class SpecimenScatter:
    """Standard deviations between specimens of one kind: of ln E, ln mass and of the friction."""

    modulus: float
    mass: float
    friction: float


#: How alike specimens are, by where the kind comes from. All assumed.
SCATTER = {
    "grown": SpecimenScatter(modulus=0.15, mass=0.15, friction=0.05),
    "made": SpecimenScatter(modulus=0.06, mass=0.03, friction=0.05),
}


@dataclass(frozen=True, slots=True)
class HouseholdObject:
    """A kind of thing as it lies on a table.

    Parameters
    ----------
    name
        What it is called.
    group
        "soft fragile", "soft robust", "firm fragile" or "firm robust".
    origin
        "grown" or "made": how much its specimens differ.
    numbers
        With their sources.
    """

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
        """How much its specimens differ."""
        return SCATTER[self.origin]

    @property
    def kind(self) -> TwinObject:
        """As the twin pinches it; specimens scatter around it."""
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
        """Stiffness behind the contacts, N/m."""
        n = self.numbers
        if n.bulk is not None:
            return n.bulk.value
        if n.radius is None:
            raise ValueError(f"{self.name} is flat and has no bulk stiffness")
        area = math.pi * n.radius.value**2
        return gent_modulus(n.shore_a.value) * area / n.thickness.value
