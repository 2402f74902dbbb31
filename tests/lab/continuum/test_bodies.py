"""Finite elements of bodies at rest: masses, patches of even strain, and Hertz's contact."""

import math

import numpy as np
import pytest
from scipy.sparse import diags
from scipy.sparse.linalg import splu

from firstcontact.core.physics import POISSON, hertz_stiffness
from firstcontact_lab.continuum.bodies import Body, Material, cylinder, shell, sphere

RUBBER = Material(1100.0, 2e6)
BALL = 4 / 3 * math.pi
BODIES = {
    "cylinder": (cylinder(0.04, 0.035, RUBBER), math.pi * 0.04**2 * 0.035),
    "sphere": (sphere(0.037, RUBBER), BALL * 0.037**3),
    "shell": (shell(0.033, 0.0065, RUBBER), BALL * (0.033**3 - 0.0265**3)),
}


@pytest.mark.parametrize("name", BODIES)
def test_body_has_its_mass_and_feels_no_force_when_it_moves_as_one(name: str) -> None:
    body, volume = BODIES[name]
    assert body.masses.min() > 0
    assert body.masses.sum() == pytest.approx(1100 * volume, rel=0.015)
    rising = np.tile([0.0, 1.0], len(body.nodes))
    for matrix in body.stiffness:
        assert abs(matrix @ rising).max() < 1e-9 * abs(matrix).max()


@pytest.mark.parametrize("name", BODIES)
def test_even_strain_stores_the_energy_of_hooke(name: str) -> None:
    body, _ = BODIES[name]
    strain = 1e-3
    moved = (body.nodes * [POISSON * strain, -strain]).ravel()
    volume, shear = body.stiffness
    stored = moved @ ((volume + shear) @ moved) / 2
    exact = RUBBER.modulus * strain**2 / 2 * body.masses.sum() / RUBBER.density
    assert stored == pytest.approx(exact, rel=1e-6)


def pressed(body: Body, depth: float, radius: float) -> float:
    """Return the force of a rigid sphere at rest, with the body's far end held."""
    volume, shear = body.stiffness
    elastic = volume + shear
    r, height = body.nodes.T
    is_held = np.zeros((len(r), 2), bool)
    is_held[:, 0] = r < 1e-9
    is_held[height > height.max() - 1e-9] = True
    free = np.flatnonzero(~is_held.ravel())
    heights = 2 * body.surface + 1
    overlap = depth - r[body.surface] ** 2 / (2 * radius)
    penalty = 100 * body.material.modulus / body.size * body.areas
    touched = overlap > 0
    for _ in range(20):
        added, load = np.zeros(elastic.shape[0]), np.zeros(elastic.shape[0])
        added[heights[touched]] = penalty[touched]
        load[heights[touched]] = (penalty * overlap)[touched]
        moved = np.zeros_like(load)
        matrix = (elastic + diags(added)).tocsr()[free][:, free]
        moved[free] = splu(matrix.tocsc()).solve(load[free])
        left = overlap - moved[heights]
        if (touched == (left > 0)).all():
            break
        touched = left > 0
    return float((penalty * np.maximum(left, 0)).sum())


@pytest.mark.parametrize("modulus", [0.4e6, 4e6])
@pytest.mark.parametrize("depth", [0.1e-3, 0.4e-3])
def test_pressed_half_space_has_the_force_of_hertz(modulus: float, depth: float) -> None:
    half_space = cylinder(0.3, 0.3, Material(1100.0, modulus), size=0.1e-3)
    expected = hertz_stiffness(modulus / (1 - POISSON**2), 0.01) * depth**1.5
    assert pressed(half_space, depth, 0.01) == pytest.approx(expected, rel=0.03)
