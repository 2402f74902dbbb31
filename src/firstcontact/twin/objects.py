"""What is pinched: the five blocks and the eight everyday objects of the paper."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from firstcontact.core.errors import InputError
from firstcontact.core.pinch import Role
from firstcontact.twin.fragility import Fragility
from firstcontact.twin.materials import gent_modulus
from firstcontact.twin.parameters import ObjectParameters

#: Of silicone on silicone, and of silicone on the skin of fruit.
FRICTION = 0.7
SKIN_FRICTION = 0.5


@dataclass(frozen=True, slots=True)
class TwinObject:
    """An object as labelled, and as the mechanics sees its kind.

    ``nominal`` has the modulus that the durometer reading stands for; a
    specimen's own modulus scatters around it.
    """

    name: str
    shore_a: float
    role: Role
    nominal: ObjectParameters
    modulus_scatter: float
    """Standard deviation of ln E between specimens of one reading."""
    friction: float = FRICTION
    """Coefficient of friction against the pad's silicone."""
    fragility: Fragility | None = None
    """None for what no fingertip of this hand breaks."""

    @property
    def mass(self) -> float:
        """Of the whole object, kg."""
        return 2 * self.nominal.face_mass


def block(shore_a: float) -> TwinObject:
    """A block as the paper's, of any Shore A."""
    # 7 x 7 x 3.5 cm, pinched across the 3.5 cm; silicone of 1.1 g/cm3.
    modulus = gent_modulus(shore_a)
    mass = 0.07 * 0.07 * 0.035 * 1100
    bulk = modulus * 0.07 * 0.07 / 0.035
    loss = 0.12
    nominal = ObjectParameters(
        modulus=modulus,
        face_mass=mass / 2,
        bulk_stiffness=bulk,
        bulk_damping=loss * math.sqrt(bulk * mass / 4),
    )
    return TwinObject(f"block {shore_a:g}", shore_a, Role.TRAIN, nominal, 0.06)


def _round(shore_a: float, radius: float, mass: float, loss: float) -> ObjectParameters:
    # ``loss`` is the loss factor of the material, of its bulk as of its contact.
    # A ball squeezed across its diameter, as a column of its own cross-section.
    modulus = gent_modulus(shore_a)
    bulk = modulus * math.pi * radius / 2
    return ObjectParameters(
        modulus=modulus,
        radius=radius,
        face_mass=mass / 2,
        bulk_stiffness=bulk,
        bulk_damping=loss * math.sqrt(bulk * mass / 4),
        clamp_stiffness=60.0,
        clamp_damping=0.8,
        arm_share=2 * loss,
        contact_loss=loss,
    )


def _apple(k: int, shore_a: float) -> TwinObject:
    return TwinObject(
        f"apple {k}", shore_a, Role.TEST, _round(shore_a, 0.037, 0.18, 0.15), 0.15, 0.5
    )


def _orange(k: int, shore_a: float) -> TwinObject:
    return TwinObject(
        f"orange {k}", shore_a, Role.TEST, _round(shore_a, 0.037, 0.20, 0.45), 0.15, 0.5
    )


def _tennis_ball(k: int, shore_a: float) -> TwinObject:
    # Hollow. The wall is compressed where it is touched, which is the contact; then
    # it bends, which is the bulk here: twice the static stiffness that the rules
    # of tennis ask for at 6 mm. The mass of the bending cap alone is left out.
    solid = _round(shore_a, 0.033, 0.0577, 0.15)
    shell = solid._replace(bulk_stiffness=2.4e4, bulk_damping=6.0)
    return TwinObject(f"tennis ball {k}", shore_a, Role.TEST, shell, 0.06)


def _avocado(k: int, shore_a: float) -> TwinObject:
    return TwinObject(
        f"avocado {k}", shore_a, Role.TEST, _round(shore_a, 0.034, 0.19, 0.25), 0.18, 0.5
    )


BLOCKS = tuple(block(s) for s in (10, 20, 29, 43, 60))
EVERYDAY_OBJECTS = (
    _apple(1, 28), _apple(2, 26), _orange(1, 35), _orange(2, 37),
    _tennis_ball(1, 45), _tennis_ball(2, 46), _avocado(1, 59), _avocado(2, 67),
)  # fmt: skip
OBJECTS = {kind.name: kind for kind in (*BLOCKS, *EVERYDAY_OBJECTS)}


def object_named(name: str) -> TwinObject:
    """The object of that name.

    Raises
    ------
    InputError
        There is none.
    """
    if name not in OBJECTS:
        raise InputError(f"object {name!r} is not known: use one of {', '.join(OBJECTS)}")
    return OBJECTS[name]


def stiffened(parameters: ObjectParameters, factor: float) -> ObjectParameters:
    """The same object of a material whose modulus is ``factor`` times as large."""
    return parameters._replace(
        modulus=parameters.modulus * factor,
        bulk_stiffness=parameters.bulk_stiffness * factor,
    )


def specimen(kind: TwinObject, deviate: float, widen: float = 1.0) -> TwinObject:
    """One specimen: its modulus ``deviate`` standard deviations off, times ``widen``."""
    factor = math.exp(kind.modulus_scatter * widen * deviate)
    return replace(kind, nominal=stiffened(kind.nominal, factor))
