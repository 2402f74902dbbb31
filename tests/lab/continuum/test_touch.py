"""Touches of finite elements: a closed form, energy, mesh and step."""

from dataclasses import replace

import numpy as np
import pytest

from firstcontact.core.physics import POISSON, hertz_stiffness
from firstcontact.twin.mechanics import FingerParameters
from firstcontact_lab.continuum.bodies import Material, cylinder, sphere
from firstcontact_lab.continuum.touch import Touch, touch

#: A skin that nothing ties to the finger.
SKIN = FingerParameters()._replace(
    pad_stiffness=0.0, pad_stiffening=0.0, pad_arm_stiffness=0.0, pad_damping=0.0, skin_mass=0.01
)
MASS, RADIUS, MODULUS = 0.18, 0.037, 4e6
BALL = sphere(RADIUS, Material(MASS / (4 / 3 * np.pi * RADIUS**3), MODULUS))


def test_impact_of_two_spheres_follows_hertz() -> None:
    reduced = 1 / (1 / SKIN.skin_mass + 1 / MASS)
    radius = 1 / (1 / SKIN.tip_radius + 1 / RADIUS)
    contact = MODULUS / (1 - POISSON**2)
    depth = (15 * reduced * SKIN.speed**2 / (16 * contact * np.sqrt(radius))) ** 0.4
    lasts = 2.94 * depth / SKIN.speed
    found = touch(SKIN, BALL, duration=1.5 * lasts)
    pressed = found.times[found.force > 0]
    force = hertz_stiffness(contact, radius) * depth**1.5
    assert found.force.max() == pytest.approx(force, rel=0.02)
    assert np.ptp(pressed) == pytest.approx(lasts, rel=0.02)


def test_energy_is_kept_without_loss_and_falls_with_it() -> None:
    start = SKIN.skin_mass * SKIN.speed**2 / 2
    kept = touch(SKIN, BALL, duration=0.008).energy / start
    assert kept == pytest.approx(np.ones(kept.size), abs=0.005)
    relaxing = replace(BALL, material=replace(BALL.material, arms=((0.5, 2e-3), (0.2, 0.1))))
    lost = touch(SKIN, relaxing, duration=0.008).energy / start
    assert np.diff(lost).max() < 1e-3
    assert lost[-1] < 0.95


def peaks(found: Touch) -> list[float]:
    return [found.volts.max(), found.force.max()]


def test_mesh_and_step_hardly_change_a_touch() -> None:
    finger, rubber = FingerParameters(), Material(1100.0, 1.1e6, ((0.25, 4e-3),))
    block, fine = (cylinder(0.0395, 0.035, rubber, size) for size in (0.25e-3, 0.18e-3))
    usual = touch(finger, block, duration=0.008)
    assert peaks(touch(finger, block, duration=0.008, step=0.5)) == pytest.approx(
        peaks(usual), rel=2e-3
    )
    assert peaks(touch(finger, fine, duration=0.008)) == pytest.approx(peaks(usual), rel=0.01)
