"""Objects to pinch: the flat blocks and the everyday objects of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstcontact.core import Role
from firstcontact.core.physics import gent_modulus
from firstcontact.twin.mechanics import ObjectParameters

#: Coefficients of friction: silicone on silicone, and silicone on the skin of fruit.
FRICTION = 0.7
SKIN_FRICTION = 0.5
#: Share of its stiffness that a broken object keeps.
CRUSHED = 0.02


@dataclass(frozen=True, slots=True)
class Fragility:
    """Weibull distribution of the force at which one finger breaks the object."""

    scale: float
    modulus: float

    def draw(self, rng: np.random.Generator) -> float:
        return self.scale * float(rng.weibull(self.modulus))


@dataclass(frozen=True, slots=True)
class TwinObject:
    """Simulated object with its label and its mechanical parameters.

    ``nominal`` holds the parameters that match ``shore_a``. Each specimen (copy of the object) has
    its own stiffness, which scatters around the nominal one.
    """

    name: str
    shore_a: float
    role: Role
    nominal: ObjectParameters
    modulus_scatter: float
    """Standard deviation of ln(modulus) between specimens of the same Shore A."""
    friction: float = FRICTION
    """Coefficient of friction against the pad's silicone."""
    fragility: Fragility | None = None
    """Distribution of the breaking force; None for an object that this hand cannot break."""

    @property
    def mass(self) -> float:
        """Mass of the whole object, kg."""
        return 2 * self.nominal.face_mass


def block(shore_a: float) -> TwinObject:
    """Return a flat block of the paper's size, with any Shore A."""
    # 7 x 7 x 3.5 cm, pinched across the 3.5 cm; silicone of 1.1 g/cm3.
    mass = 0.07 * 0.07 * 0.035 * 1100
    bulk = gent_modulus(shore_a) * 0.07 * 0.07 / 0.035
    solid = ObjectParameters.solid(shore_a, mass, bulk, 0.12)
    usual = ObjectParameters()
    nominal = solid._replace(arm_share=usual.arm_share, contact_loss=usual.contact_loss)
    return TwinObject(f"block {shore_a:g}", shore_a, Role.TRAIN, nominal, 0.06)


def _round(shore_a: float, radius: float, mass: float, loss: float) -> ObjectParameters:
    # A ball pressed across its diameter is as stiff as a column of its own cross-section.
    column = gent_modulus(shore_a) * math.pi * radius / 2
    return ObjectParameters.solid(shore_a, mass, column, loss)._replace(
        radius=radius, clamp_stiffness=60.0, clamp_damping=0.8
    )


def _fruit(
    name: str, shore_a: float, radius: float, mass: float, loss: float, scatter: float = 0.15
) -> TwinObject:
    nominal = _round(shore_a, radius, mass, loss)
    return TwinObject(name, shore_a, Role.TEST, nominal, scatter, SKIN_FRICTION)


def _tennis_ball(name: str, shore_a: float) -> TwinObject:
    # Hollow. The contact compresses the wall, and then the wall bends, which is the bulk here. Its
    # stiffness is twice the static one that the rules of tennis require at 6 mm. The mass of the
    # bending cap alone is ignored.
    shell = _round(shore_a, 0.033, 0.0577, 0.15)._replace(bulk_stiffness=2.4e4, bulk_damping=6.0)
    return TwinObject(name, shore_a, Role.TEST, shell, 0.06)


#: Flat silicone blocks of the paper, of 10, 20, 29, 43 and 60 Shore A.
BLOCKS = tuple(block(s) for s in (10, 20, 29, 43, 60))
EVERYDAY_OBJECTS = (
    _fruit("apple 1", 28, 0.037, 0.18, 0.15),
    _fruit("apple 2", 26, 0.037, 0.18, 0.15),
    _fruit("orange 1", 35, 0.037, 0.20, 0.45),
    _fruit("orange 2", 37, 0.037, 0.20, 0.45),
    _tennis_ball("tennis ball 1", 45),
    _tennis_ball("tennis ball 2", 46),
    _fruit("avocado 1", 59, 0.034, 0.19, 0.25, 0.18),
    _fruit("avocado 2", 67, 0.034, 0.19, 0.25, 0.18),
)
#: Objects of the paper, by name.
OBJECTS = {kind.name: kind for kind in (*BLOCKS, *EVERYDAY_OBJECTS)}
