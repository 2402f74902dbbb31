"""Tests that the mechanical energy never grows without motor and noise."""

import numpy as np
import pytest
from numpy.typing import NDArray
from pinches import Fingers, integrated, moving
from scipy.optimize import brentq

from firstcontact.twin import BLOCKS
from firstcontact.twin.mechanics import (
    FINGER_STATES,
    INDENTATION,
    FingerParameters,
    ObjectParameters,
    contact_stiffness,
)
from firstcontact.twin.objects import EVERYDAY_OBJECTS

STEP = 5e-6


def run(
    fingers: Fingers, o: ObjectParameters, touch: tuple[float, float], end: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the state and the indentations at ``end``."""
    times = np.linspace(0.0, end, max(round(end / STEP / 4), 1) + 1)
    x = moving(fingers)
    out = integrated(fingers, o, touch, times, x, substeps=4)
    return x, np.nan_to_num(out[-1, :, INDENTATION])


def contact_energy(
    stiffness: float, o: ObjectParameters, depth: float, fast: float, slow: float
) -> float:
    """Return the energy in a contact, J: of Hertz's spring, of both arms, and of the dent."""
    arms = o.arm_share * fast + o.slow_share * slow
    dent = stiffness / o.dent_stiffness
    left = max(depth - dent * arms, 0.0)
    pressed = brentq(lambda d: d + dent * d**1.5 - left, 0.0, left) if left > 0 else 0.0
    force = stiffness * (pressed**1.5 + arms)
    if force <= 0:  # the face recovers by itself
        pressed, force = max(-arms, 0.0) ** (2 / 3), 0.0
    total = 0.4 * stiffness * pressed**2.5 + force**2 / (2 * o.dent_stiffness)
    for share, arm in ((o.arm_share, fast), (o.slow_share, slow)):
        viscous = max(pressed**1.5 - arm, 0.0)  # part of the force that the arm has forgotten
        spring = 0.4 * pressed**2.5 - viscous * pressed + 0.6 * viscous ** (5 / 3)
        total += stiffness * share * spring
    return float(total)


def energy(
    x: NDArray[np.float64], depth: NDArray[np.float64], fingers: Fingers, o: ObjectParameters
) -> float:
    """Return the kinetic and elastic energy, J."""
    total = 0.0
    for f, p in enumerate(fingers):
        s = x[f * FINGER_STATES : (f + 1) * FINGER_STATES]
        masses = (p.drive_mass, p.phalanx_mass, p.board_mass, p.skin_mass)
        total += sum(0.5 * m * v**2 for m, v in zip(masses, s[1:8:2], strict=True))
        total += 0.5 * p.link_stiffness * (s[0] - s[2]) ** 2
        total += 0.5 * p.mount_stiffness * (s[2] - s[4]) ** 2
        squeeze = s[4] - s[6]
        total += 0.5 * p.pad_stiffness * squeeze**2 + 0.25 * p.pad_stiffening * squeeze**4
        total += 0.5 * p.pad_arm_stiffness * s[8] ** 2
        total += contact_energy(contact_stiffness(p, o), o, max(depth[f], 0.0), *s[9:11])
    face, face_v, other_face, other_face_v = x[2 * FINGER_STATES :]
    total += 0.5 * o.face_mass * (face_v**2 + other_face_v**2)
    total += 0.5 * o.bulk_stiffness * (face - other_face) ** 2
    total += 0.25 * o.clamp_stiffness * (face**2 + other_face**2)
    return float(total)


def scatter(rng: np.random.Generator, parameters: tuple[float, ...]) -> NDArray[np.float64]:
    """Return the parameters, each times e^N(0, 0.5)."""
    return np.asarray(parameters) * np.exp(0.5 * rng.standard_normal(len(parameters)))


@pytest.mark.parametrize("seed", range(12))
def test_energy_never_increases(seed: int) -> None:
    rng = np.random.default_rng(seed)
    kinds = (*BLOCKS, *EVERYDAY_OBJECTS)
    o = ObjectParameters(*scatter(rng, kinds[seed % len(kinds)].nominal))
    fingers = tuple(
        FingerParameters(*scatter(rng, FingerParameters()))._replace(drive_force=0.0)
        for _ in range(2)
    )
    touch = (0.001, 0.001 + rng.uniform(0, 0.01))
    history = []
    for end in np.linspace(0.0005, 0.030, 120):
        x, depth = run((fingers[0], fingers[1]), o, touch, float(end))
        history.append(energy(x, depth, (fingers[0], fingers[1]), o))
    grown = np.diff(history).max() / history[0]
    assert grown < 1e-6
    assert history[-1] < 0.999 * history[0], "nothing was lost: contact did not happen"


@pytest.mark.parametrize("loss", [0.0, 60.0])
def test_backdriven_drive_adds_no_energy(loss: float) -> None:
    o = BLOCKS[1].nominal
    p = FingerParameters()._replace(drive_force=0.0)
    x, gap = moving((p, p)), np.full(2, np.nan)
    history = []
    for piece in range(300):
        times = (piece + np.linspace(0, 1, 11)) * 5e-4
        out = integrated((p, p), o, (0.001, 0.004), times, x, gap, 10, loss)
        depth = np.nan_to_num(out[-1, :, INDENTATION])
        history.append(energy(x, depth, (p, p), o))
    assert np.diff(history).max() / history[0] < 1e-6
    # The bounce takes most of what the drives had; damped, it takes more.
    assert (history[-1] < 0.3 * history[0]) == (loss > 0)


def test_momentum_is_conserved() -> None:
    o = BLOCKS[2].nominal._replace(clamp_stiffness=0.0, clamp_damping=0.0)
    p = FingerParameters()._replace(drive_force=0.0)

    def momentum(x: NDArray[np.float64]) -> float:
        masses = np.array([p.drive_mass, p.phalanx_mass, p.board_mass, p.skin_mass])
        index, thumb = x[1:8:2], x[FINGER_STATES + 1 : FINGER_STATES + 8 : 2]
        faces = x[2 * FINGER_STATES + 1 :: 2]
        return float(masses @ (index - thumb) + o.face_mass * faces.sum())

    slower = p._replace(speed=0.05)
    start_state, _ = run((p, slower), o, (0.001, 0.004), STEP)
    end_state, depth = run((p, slower), o, (0.001, 0.004), 0.02)
    assert (depth > 0).all()
    assert momentum(end_state) == pytest.approx(momentum(start_state), rel=1e-9)
