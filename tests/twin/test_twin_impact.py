"""Tests of the mechanics in limits with closed forms."""

import numpy as np
import pytest
from numpy.typing import NDArray
from pinches import integrated

from firstcontact.core.physics import contact_modulus, hertz_stiffness
from firstcontact.twin.mechanics import (
    CONTACT_FORCE,
    STATES,
    FingerParameters,
    ObjectParameters,
    contact_arms,
    contact_stiffness,
)

NEVER = 1e9
#: Nothing but the skin: no drive, and nothing that ties it to the board.
SKIN_ALONE = FingerParameters()._replace(
    drive_force=0.0, link_stiffness=0.0, link_damping=0.0, pad_stiffness=0.0, pad_stiffening=0.0,
    pad_arm_stiffness=0.0, pad_damping=0.0,
)  # fmt: skip
#: Phalanx, board and skin as one: springs so stiff that nothing between them moves.
RIGID = SKIN_ALONE._replace(mount_stiffness=1e9, pad_stiffness=1e9)
#: A flat face that does not move and loses nothing.
WALL = ObjectParameters(
    modulus=1e6, face_mass=1e9, clamp_stiffness=0.0, clamp_damping=0.0, arm_share=0.0,
)  # fmt: skip


def hertz_impact(
    mass: float, speed: float, modulus: float, radius: float
) -> tuple[float, float, float]:
    """Return the closed form of an elastic impact against a fixed body.

    The result is the largest indentation, m, the peak force, N, and the contact time, s: Johnson
    (1985), Contact Mechanics, section 11.4.
    """
    depth = (15 * mass * speed**2 / (16 * modulus * np.sqrt(radius))) ** 0.4
    return depth, hertz_stiffness(modulus, radius) * depth**1.5, 2.94 * depth / speed


def impact(
    p: FingerParameters, o: ObjectParameters, speed: float, duration: float, dt: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return times, contact force of the index, and the last state of one impact."""
    times = np.arange(0.0, duration, dt)
    state = np.zeros(STATES)
    state[1:8:2] = speed
    out = integrated((p, p), o, (10.25 * dt, NEVER), times, state)
    return times, out[:, 0, CONTACT_FORCE], state


def effective_mass(p: FingerParameters) -> float:
    return p.skin_mass if p is SKIN_ALONE else p.skin_mass + p.board_mass + p.phalanx_mass


@pytest.mark.parametrize("p", [SKIN_ALONE, RIGID], ids=["skin alone", "rigid finger"])
@pytest.mark.parametrize("modulus", [0.4e6, 4e6])
@pytest.mark.parametrize("radius", [1e3, 0.035], ids=["flat", "round"])
def test_peak_force_and_contact_time_follow_hertz(
    p: FingerParameters, modulus: float, radius: float
) -> None:
    speed = 0.13
    o = WALL._replace(modulus=modulus, radius=radius)
    tip = 1 / (1 / p.tip_radius + 1 / radius)
    modulus_pair = contact_modulus(p.pad_modulus, modulus)
    _, peak, lasts = hertz_impact(effective_mass(p), speed, modulus_pair, tip)
    times, force, _ = impact(p, o, speed, 1.5 * lasts, 0.4e-6 if p is RIGID else 2e-6)
    pressed = times[force > 0]
    assert force.max() == pytest.approx(peak, rel=0.02)
    assert pressed[-1] - pressed[0] == pytest.approx(lasts, rel=0.02)


def test_lossless_wall_returns_all_speed() -> None:
    _, _, state = impact(SKIN_ALONE, WALL, 0.13, 0.02, 2e-6)
    assert state[7] == pytest.approx(-0.13, rel=1e-4)


def test_maxwell_arm_dissipates_energy_and_never_pulls() -> None:
    _, force, state = impact(SKIN_ALONE, WALL._replace(arm_share=0.5), 0.13, 0.02, 2e-6)
    assert 0.5 < -state[7] / 0.13 < 0.99
    assert force.min() >= 0


@pytest.mark.parametrize("dent", [3e3, 4e4, np.inf])
@pytest.mark.parametrize("confined", [0.0, 2.5e-5])
def test_shell_and_pad_on_a_rigid_back_store_all_of_the_energy(
    dent: float, confined: float
) -> None:
    p = SKIN_ALONE._replace(pad_confinement=confined)
    _, force, state = impact(p, WALL._replace(dent_stiffness=dent), 0.13, 0.02, 2e-6)
    stiffness, peak = contact_stiffness(p, WALL), force.max()
    e = confined * stiffness
    depths = np.linspace(0.0, (peak / stiffness) ** (2 / 3), 20_001)
    forces = stiffness * depths**1.5
    forces *= 1 + 1.5 * e * depths**0.5 + 2.6 * e**2 * depths + 5 * e**3 * depths**1.5
    below = forces <= peak
    pressed = np.trapezoid(forces[below], depths[below])
    assert pressed + peak**2 / (2 * dent) == pytest.approx(p.skin_mass * 0.13**2 / 2, rel=2e-3)
    assert state[7] == pytest.approx(-0.13, rel=1e-4)


def test_arms_follow_the_closed_form_of_a_held_indentation() -> None:
    o = WALL._replace(arm_share=0.5, arm_relaxation=4e-3, slow_share=2.0, slow_relaxation=0.1)
    heavy = SKIN_ALONE._replace(skin_mass=1e6)
    # A wall that is pressed in 0.1 ms and then held: its force falls with both arms.
    state = np.zeros(STATES)
    state[7] = 1.0
    quick = np.arange(0.0, 1.1e-4, 1e-6)
    gap = np.full(2, np.nan)
    integrated((heavy, heavy), o, (5e-7, NEVER), quick, state, gap)
    state[7] = 0.0
    times = quick[-1] + np.linspace(0.0, 0.02, 201)
    out = integrated((heavy, heavy), o, (5e-7, NEVER), times, state, gap, substeps=8)
    force, held = out[:, 0, CONTACT_FORCE], times - times[0]
    expected = 1 + 0.5 * np.exp(-held / 4e-3) + 2 * np.exp(-held / 0.1)
    assert force / force[0] == pytest.approx(expected / 3.5, rel=0.02)


def test_contact_relaxes_as_pad_and_object_in_series() -> None:
    p, rubber = FingerParameters(), ObjectParameters()
    assert contact_arms(p, rubber).arm_share == pytest.approx(rubber.arm_share)
    fruit = rubber._replace(modulus=p.pad_modulus, arm_share=1.0, slow_share=2.0)
    touched = contact_arms(p, fruit)
    # Half of the contact is the pad, whose silicone stays 1 within a second, and has 1.25 at once.
    assert touched.slow_share == pytest.approx(2 / (1 + 1 / 3) - 1)
    assert touched.arm_share == pytest.approx(2 / (1 / 1.25 + 1 / 4) - 1.5)
    rigid = contact_arms(p._replace(pad_modulus=1e15), fruit)
    assert rigid[-5:] == pytest.approx(fruit[-5:])
