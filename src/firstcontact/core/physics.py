"""Physics that several rooms share: commands to hands, contact mechanics, shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import sqrt

from firstcontact.core._errors import ArgumentError
from firstcontact.core.text import parse_float

#: Acceleration of free fall, m/s^2.
GRAVITY = 9.81
#: Poisson's ratio of rubber and soft tissue: nearly incompressible.
POISSON = 0.49
#: Shape hint of a flat object.
FLAT = "flat"
#: Smallest and largest radius of a hint, mm. The training had no smaller radii, and objects with
#: larger radii are as good as flat.
LEAST, MOST = 5.0, 200.0


def holding_force(mass: float, friction: float) -> float:
    """Return the grip force, N, that just holds a mass (kg) between two fingers."""
    return mass * GRAVITY / (2 * friction)


def gent_modulus(shore_a: float) -> float:
    """Return Young's modulus, Pa, of an elastomer with this Shore A, by Gent's formula."""
    return 1e6 * 0.0981 * (56 + 7.62336 * shore_a) / (0.137505 * (254 - 2.54 * shore_a))


def gent_shore_a(modulus: float) -> float:
    """Return the Shore A of an elastomer with this Young's modulus, Pa, by Gent's formula."""
    scaled = modulus * 0.137505 / (1e6 * 0.0981)
    return (254 * scaled - 56) / (7.62336 + 2.54 * scaled)


def contact_modulus(first: float, second: float, poisson: float = POISSON) -> float:
    """Return the contact modulus E*, Pa, of two bodies from their Young's moduli, Pa.

    Both bodies have the Poisson's ratio ``poisson``.
    """
    plane_strain = 1 - poisson**2
    return 1 / (plane_strain / first + plane_strain / second)


def hertz_stiffness(modulus: float, radius: float) -> float:
    """Return the stiffness K, N/m^1.5, of Hertz' contact between a sphere and a plane.

    ``modulus`` is the contact modulus, Pa, and ``radius`` that of the sphere, m. At the
    indentation d the force is F = K d^1.5.
    """
    return 4 / 3 * modulus * sqrt(radius)


@dataclass(frozen=True, slots=True)
class Command:
    """Command to the motors of a hand. It applies until the next command.

    Parameters
    ----------
    speed
        Speed at which each fingertip closes, m/s. A negative speed opens the hand, 0 stops it.
    force
        Upper limit on the force of each fingertip, N.

    Examples
    --------
    >>> gentle = Command(speed=0.02, force=1.5)
    >>> gentle.force
    1.5
    """

    speed: float
    force: float


def is_same_rate(rate: float, other: float) -> bool:
    """Return True if two rates (Hz) differ by at most 1 %, as the clocks of two devices may."""
    return abs(rate - other) <= 0.01 * other


def parse_radius(text: str) -> float:
    """Parse a shape hint, such as "37 mm". Return the radius, m: inf for "flat", NaN for "".

    Raises ArgumentError for any other text.
    """
    word = text.strip().lower()
    if not word:
        return math.nan
    if word == FLAT:
        return math.inf
    try:
        radius = parse_float(word.removesuffix("mm"))
    except ValueError:
        radius = math.nan
    if not LEAST <= radius <= MOST:
        raise ArgumentError(
            f"{text.strip()!r} is not a shape of an object: give {FLAT!r}, or a radius from "
            f"{LEAST:g} to {MOST:g} mm",
            parameter="shape",
        )
    return radius / 1000


def radius_text(radius: float | None) -> str:
    """Return a radius, m, as a shape hint: "radius 37 mm", "flat" for inf, "" for None or NaN."""
    if radius is None or math.isnan(radius):
        return ""
    return FLAT if math.isinf(radius) else f"radius {1000 * radius:g} mm"
