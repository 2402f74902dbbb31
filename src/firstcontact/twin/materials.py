"""From a durometer reading to a contact stiffness."""

from __future__ import annotations

import math

#: Poisson's ratio of rubber and soft tissue: nearly incompressible.
POISSON = 0.49


def gent_modulus(shore_a: float) -> float:
    """Young's modulus of an elastomer, Pa.

    Parameters
    ----------
    shore_a
        Durometer reading, 0 < Shore A < 100.

    References
    ----------
    Gent, A. N. (1958). On the relation between indentation hardness and
    Young's modulus. Rubber Chemistry and Technology 31(4), 896-906.
    """
    return 1e6 * 0.0981 * (56 + 7.62336 * shore_a) / (0.137505 * (254 - 2.54 * shore_a))


def loglinear_modulus(shore_a: float) -> float:
    """The other published fit, Pa: log10(E / MPa) = 0.0235 S - 0.6403.

    Shown beside :func:`gent_modulus` in the documentation: how far the two are
    apart is how well a Shore reading fixes a modulus at all.
    """
    return float(1e6 * 10 ** (0.0235 * shore_a - 0.6403))


def plane_strain_modulus(first: float, second: float) -> float:
    """Contact modulus E* of two bodies with Young's moduli in Pa (Hertz)."""
    return 1 / ((1 - POISSON**2) / first + (1 - POISSON**2) / second)


def hertz_stiffness(contact_modulus: float, radius: float) -> float:
    """K in F = K d^1.5, N/m^1.5, for E* in Pa and the relative radius in m."""
    return 4 / 3 * contact_modulus * math.sqrt(radius)


def hertz_impact(
    mass: float, speed: float, contact_modulus: float, radius: float
) -> tuple[float, float, float]:
    """Closed form of an elastic impact against a fixed body.

    Returns
    -------
    tuple
        Largest indentation (m), peak force (N), contact time (s); Johnson (1985),
        Contact Mechanics, section 11.4.
    """
    depth = (15 * mass * speed**2 / (16 * contact_modulus * math.sqrt(radius))) ** 0.4
    force = hertz_stiffness(contact_modulus, radius) * depth**1.5
    return depth, force, 2.94 * depth / speed
