"""What breaks in a hand: an egg's shell, a potato crisp, a ripe berry.

How stiff a thing is says little about what it bears. Where each number comes from
is in ``docs/reference/twin-parameters.md``.
"""

from __future__ import annotations

import math

from firstcontact.core.pinch import Role
from firstcontact.twin.fragility import Fragility
from firstcontact.twin.materials import gent_modulus
from firstcontact.twin.objects import SKIN_FRICTION, TwinObject
from firstcontact.twin.parameters import ObjectParameters


def _thing(
    name: str, shore_a: float, mass: float, radius: float, bulk: float, loss: float,
    fragility: Fragility,
) -> TwinObject:  # fmt: skip
    # Lying loosely: too light to be held by its weight.
    nominal = ObjectParameters(
        modulus=gent_modulus(shore_a),
        radius=radius,
        face_mass=mass / 2,
        bulk_stiffness=bulk,
        bulk_damping=loss * math.sqrt(bulk * mass / 4),
        clamp_stiffness=20.0,
        clamp_damping=0.2,
        arm_share=2 * loss,
        contact_loss=loss,
    )
    return TwinObject(name, shore_a, Role.TEST, nominal, 0.15, SKIN_FRICTION, fragility)


#: A quail's egg, pinched across.
EGG_SHELL = _thing("egg shell", 95, 0.0127, 0.013, 7.0e3, 0.05, Fragility(10.8, 6.0))
#: Pinched through its middle, where it bends.
CRISP = _thing("crisp", 95, 0.002, 0.03, 2.5e3, 0.05, Fragility(2.2, 4.0))
#: Like a ripe raspberry.
BERRY = _thing("berry", 5, 0.005, 0.010, 4.4e3, 0.4, Fragility(3.0, 5.0))

BRITTLE = (EGG_SHELL, CRISP, BERRY)
