"""Objects that the twin pinches: the flat blocks and the everyday objects of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from firstcontact.core import Role
from firstcontact.core.physics import FLAT, MOST, POISSON, gent_modulus
from firstcontact.twin.mechanics import ObjectParameters

#: Coefficient of friction of blocks and felt: rubber on a finger's skin has 0.9 [5].
FRICTION = 0.7
#: Coefficient of friction of fruit, shell and crisp: a quail's egg has 0.27 to 0.30 on glass, steel
#: and wood [6].
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
    def shape(self) -> str:
        """Shape for labels: "flat", or "" for unknown."""
        return FLAT if self.nominal.radius > MOST / 1000 else ""

    @property
    def mass(self) -> float:
        """Mass of the whole object, kg."""
        return 2 * self.nominal.face_mass


#: Loss factor of the blocks' silicone.
SILICONE_LOSS = 0.12
#: Loss factor of oranges over seconds: 42 % of their stiffness is left after 15 minutes.
ORANGE_LOSS = math.tan(math.pi / 2 * math.log(1 / 0.42) / math.log(900))


def slow_share(loss: float) -> float:
    """Return the share of a material's stiffness that relaxes slowly, given its loss factor.

    The modulus falls with the power -2 / pi atan(loss) of time (fractional law). The slow share is
    the part that it loses in the two decades of time before a durometer is read, after 1 s. The
    Shore A of rubber includes the relaxation of rubber. So the relaxation of silicone is
    subtracted.
    """
    power = 2 / math.pi * (math.atan(loss) - math.atan(SILICONE_LOSS))
    return float(max(100**power - 1, 0.0))


def block(shore_a: float) -> TwinObject:
    """Return a flat block of the paper's size with this Shore A."""
    # 7 x 7 x 3.5 cm, pinched across the 3.5 cm; silicone of 1.1 g/cm3.
    mass = 0.07 * 0.07 * 0.035 * 1100
    bulk = gent_modulus(shore_a) * 0.07 * 0.07 / 0.035
    solid = ObjectParameters.solid(shore_a, mass, bulk, SILICONE_LOSS)
    nominal = solid._replace(arm_share=ObjectParameters().arm_share)
    return TwinObject(f"block {shore_a:g}", shore_a, Role.TRAIN, nominal, 0.06)


def _round(
    shore_a: float, radius: float, mass: float, loss: float, slow: float = 0.0
) -> ObjectParameters:
    # A ball pressed across its diameter is as stiff as a column of its own cross-section.
    column = gent_modulus(shore_a) * math.pi * radius / 2
    return ObjectParameters.solid(shore_a, mass, column, loss, slow)._replace(
        radius=radius, clamp_stiffness=60.0, clamp_damping=0.8
    )


def _fruit(
    name: str, shore_a: float, radius: float, mass: float, loss: float, scatter: float = 0.15,
    slow_loss: float | None = None,
) -> TwinObject:  # fmt: skip
    slow = slow_share(loss if slow_loss is None else slow_loss)
    nominal = _round(shore_a, radius, mass, loss, slow)
    return TwinObject(name, shore_a, Role.TEST, nominal, scatter, SKIN_FRICTION)


def shell_stiffness(modulus: float, radius: float, wall: float) -> float:
    """Return the stiffness of a hollow ball against a local dent, N/m (Reissner 1946).

    ``modulus`` is in Pa. ``radius`` is the outer radius and ``wall`` the thickness of the wall, m.
    """
    middle = radius - wall / 2
    return 4 * modulus * wall**2 / (middle * math.sqrt(3 * (1 - POISSON**2)))


def _tennis_ball(name: str, shore_a: float) -> TwinObject:
    # Hollow. Each contact compresses the wall of rubber and felt, and dents it; then the whole mass
    # moves. A dent within milliseconds is stiffer by the fast arm. The mass of the dented cap and
    # the pressure inside are ignored.
    ball = _round(shore_a, 0.033, 0.0577, 0.15)
    dent = (1 + ball.arm_share) * shell_stiffness(ball.modulus, ball.radius, 6.5e-3)
    return TwinObject(name, shore_a, Role.TEST, ball._replace(dent_stiffness=dent), 0.06)


#: Flat silicone blocks of the paper, of 10, 20, 29, 43 and 60 Shore A.
BLOCKS = tuple(block(s) for s in (10, 20, 29, 43, 60))
EVERYDAY_OBJECTS = (
    _fruit("apple 1", 28, 0.037, 0.18, 0.15),
    _fruit("apple 2", 26, 0.037, 0.18, 0.15),
    _fruit("orange 1", 35, 0.037, 0.20, 0.45, slow_loss=ORANGE_LOSS),
    _fruit("orange 2", 37, 0.037, 0.20, 0.45, slow_loss=ORANGE_LOSS),
    _tennis_ball("tennis ball 1", 45),
    _tennis_ball("tennis ball 2", 46),
    _fruit("avocado 1", 59, 0.034, 0.19, 0.25, 0.18, ORANGE_LOSS),
    _fruit("avocado 2", 67, 0.034, 0.19, 0.25, 0.18, ORANGE_LOSS),
)
#: Objects of the paper, by name.
OBJECTS = {kind.name: kind for kind in (*BLOCKS, *EVERYDAY_OBJECTS)}
