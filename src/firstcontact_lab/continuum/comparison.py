"""Comparison of a simulated touch by the twin with the same touch by finite elements."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from firstcontact.twin import TwinObject
from firstcontact.twin.mechanics import (
    BUFFER,
    OUTPUTS,
    STATES,
    FingerParameters,
    ObjectParameters,
    Piece,
    contact_arms,
    contact_stiffness,
    integrate_all,
)
from firstcontact.twin.pad import ON_DIMPLES
from firstcontact_lab.continuum.bodies import SIZE, Body, Material, cylinder, shell, sphere
from firstcontact_lab.continuum.touch import DURATION, INTERVAL, touch

Values = NDArray[np.float64]
#: Density of silicone, kg/m³; area and thickness of the pad, m² and m (paper).
SILICONE, PAD_AREA, PAD_THICKNESS = 1100.0, 300e-6, 3e-3
#: Wall of a tennis ball with its felt, m.
WALL = 6.5e-3


@dataclass(frozen=True)
class Comparison:
    """Piezo voltages of one touch by the twin and by finite elements, from the contact on."""

    times: Values
    twin: Values
    elements: Values

    @property
    def peak(self) -> float:
        """Relative difference of the twin's peak voltage from that of the finite elements."""
        return float(self.twin.max() / self.elements.max()) - 1

    @property
    def rms(self) -> float:
        """RMS of the voltage difference, relative to the RMS of the finite elements' voltage."""
        difference = np.linalg.norm(self.twin - self.elements)
        return float(difference / np.linalg.norm(self.elements))

    @property
    def rms_of_peak(self) -> float:
        """RMS of the voltage difference, relative to the peak of the finite elements' voltage."""
        difference = np.sqrt(np.mean((self.twin - self.elements) ** 2))
        return float(difference / self.elements.max())


def compare(kind: TwinObject, finger: FingerParameters, *, is_rigid: bool = False) -> Comparison:
    """Simulate a touch of the object ``kind`` with the twin and with finite elements.

    In the finite elements, the fingertip is a soft pad that stands on dimples. With ``is_rigid`` it
    is a rigid sphere in front of a single spring, as in the twin.
    """
    if is_rigid:
        finger = finger._replace(pad_modulus=1e15)
        found = touch(finger, object_body(kind))
    else:
        found = touch(whole_pad(finger), object_body(kind), pad_body(finger))
    times = np.arange(0.0, DURATION, INTERVAL)
    volts = np.interp(times, found.times, found.volts)
    touched = contact_arms(finger, kind.nominal)
    return Comparison(times, twin_touch(touched, finger, times), volts)


def object_body(kind: TwinObject, size: float = SIZE) -> Body:
    """Return the mesh of an object of the twin: a block, a solid sphere, or a hollow ball."""
    o = kind.nominal
    arms = ((o.arm_share, o.arm_relaxation), (o.slow_share, o.slow_relaxation))
    if math.isinf(o.radius) or o.radius > 1:
        volume, slenderness = (
            kind.mass / SILICONE,
            o.modulus * (1 + o.slow_share) / o.bulk_stiffness,
        )
        length = math.sqrt(volume * slenderness)
        radius = math.sqrt(volume / length / math.pi)
        return cylinder(radius, length, Material(SILICONE, o.modulus, arms), size)
    inner = o.radius - WALL if math.isfinite(o.dent_stiffness) else 0.0
    density = kind.mass / (4 / 3 * math.pi * (o.radius**3 - inner**3))
    material = Material(density, o.modulus, arms)
    return shell(o.radius, WALL, material, size) if inner else sphere(o.radius, material, size)


def pad_body(finger: FingerParameters, size: float = SIZE) -> Body:
    """Return the mesh of a finger's pad: a disc with the pad's area and thickness.

    The disc relaxes at the pad's time constant, and by the same share as a silicone block.
    """
    arms = ((ObjectParameters().arm_share, finger.pad_relaxation),)
    material = Material(SILICONE, finger.pad_modulus, arms)
    return cylinder(math.sqrt(PAD_AREA / math.pi), PAD_THICKNESS, material, size)


def whole_pad(finger: FingerParameters) -> FingerParameters:
    """Return the finger with the stiffness of all dimples of the pad, touched or not."""
    names = ("pad_stiffness", "pad_stiffening", "pad_arm_stiffness", "pad_damping")
    factor = ON_DIMPLES / finger.pad_stiffness
    return finger._replace(**{name: factor * getattr(finger, name) for name in names})


def twin_touch(target: ObjectParameters, finger: FingerParameters, times: Values) -> Values:
    """Return the piezo voltage by the twin, V, without noise, for a touch of a free object.

    ``times`` are in s after the contact. The object relaxes as in :func:`contact_arms`.
    """
    target = target._replace(clamp_stiffness=0.0, clamp_damping=0.0)
    state = np.zeros(STATES)
    state[1:8:2] = finger.speed
    out = np.empty((times.size, 2, OUTPUTS))
    integrate_all([
        Piece(
            finger, finger, target, np.full(2, contact_stiffness(finger, target)),
            np.array([0.0, math.inf]), times, np.zeros((2, 2)), 1.0, 1,
            np.array([[finger.speed, 0.0]]), finger.drive_force, 0.0, 0.0, math.inf, math.inf, 1,
            state, np.full(2, np.nan), np.full(2, np.nan), out,
        )
    ])  # fmt: skip
    return out[:, 0, BUFFER].copy()
