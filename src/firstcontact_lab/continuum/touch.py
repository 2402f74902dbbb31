"""Simulation of a finger that touches a body of finite elements, in explicit time steps.

A stiff spring acts on nodes that overlap (penalty method). From the motor to the board, the finger
consists of the twin's parts and sensor. The tip is either a rigid sphere in front of the twin's
pad, or a second body of finite elements. The back of this body stands on dimples that are spread
over the board.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, diags
from scipy.sparse.linalg import eigsh

from firstcontact.twin.mechanics import FingerParameters
from firstcontact_lab.continuum.bodies import Body

Values = NDArray[np.float64]
#: Length of a touch, and time between two rows of its result, s.
DURATION, INTERVAL = 0.0165, 1e-5
#: Share of the largest stable step that is used, and time of a stiffness-proportional damping, in
#: steps: it calms nodes that chatter at the contact, and takes 0.1 % of a wave at 1 kHz.
SAFETY, CALMING = 0.75, 0.15


@dataclass(frozen=True)
class Touch:
    """Forces, motion and piezo voltage of a simulated touch, from the contact on, in SI units."""

    times: Values
    volts: Values
    force: Values
    face: Values
    """Position of the body's touched point."""
    energy: Values
    """Mechanical energy of skin, body and contact. It lacks the pad and what is behind it."""


class _Chain:
    """Moving masses of the twin's finger from the motor to the sensor's board, and the voltage."""

    def __init__(self, finger: FingerParameters, dt: float) -> None:
        self.finger, self.dt = finger, dt
        self.drive = self.phalanx = self.board = 0.0
        self.drive_v = self.phalanx_v = self.board_v = finger.speed
        self.leaked = self.volts = 0.0

    def advance(self, pad: float) -> None:
        """Simulate one time step. ``pad`` is the force of the pad on the board, N."""
        f, dt = self.finger, self.dt
        motor = min(max(f.speed_gain * (f.speed - self.drive_v), -f.drive_force), f.drive_force)
        link = f.link_stiffness * (self.drive - self.phalanx)
        link += f.link_damping * (self.drive_v - self.phalanx_v)
        mount = f.mount_stiffness * (self.phalanx - self.board)
        mount += f.mount_damping * (self.phalanx_v - self.board_v)
        volts = f.piezo_volts_per_newton * mount - self.leaked
        self.leaked += dt * volts / f.piezo_time_constant
        self.volts += 2 * math.pi * f.buffer_cutoff * dt * (f.gain * volts - self.volts)
        self.drive_v += dt * (motor - link) / f.drive_mass
        self.phalanx_v += dt * (link - mount) / f.phalanx_mass
        self.board_v += dt * (mount - pad) / f.board_mass
        self.drive += dt * self.drive_v
        self.phalanx += dt * self.phalanx_v
        self.board += dt * self.board_v


class _Pad:
    """Pad of the twin: one spring and damper in parallel for each point of its back."""

    def __init__(self, finger: FingerParameters, shares: Values, dt: float) -> None:
        self.finger, self.shares, self.dt = finger, shares, dt
        self._arm = np.zeros(shares.size)
        self._keep = math.exp(-dt / finger.pad_relaxation)

    def forces(self, squeeze: Values, rate: Values) -> Values:
        """Simulate one time step. Return the force of each point of the pad on the board, N.

        ``squeeze`` is the compression at each point, m, and ``rate`` is its rate, m/s.
        """
        f = self.finger
        slow = (f.pad_stiffness + f.pad_stiffening * squeeze * squeeze) * squeeze
        force = slow + f.pad_arm_stiffness * self._arm + f.pad_damping * rate
        self._arm = self._arm * self._keep + self.dt * rate
        return np.asarray(self.shares * force)


class _Motion:
    """Displacements and speeds of all nodes of a body over time.

    Springs in series with dampers (Maxwell arms) model the relaxation. Their elongation is linear
    in the displacements, so one vector over the nodes holds it for all elements.
    """

    def __init__(self, body: Body, penalty: Values, speed: float) -> None:
        volume, self._shear = body.stiffness
        self._elastic = volume + self._shear
        self._matrix = bmat([[self._elastic, self._shear]]).tocsr()
        self._masses = np.repeat(body.masses, 2)
        self._arms = [
            (*arm, np.zeros(self._masses.size)) for arm in body.material.arms if arm[0] > 0
        ]
        self._state = np.zeros(2 * self._masses.size)
        #: Displacements a moment ahead, and elongations of the arms, times their shares.
        self.ahead, self._relaxing = np.split(self._state, 2)
        self._moved = np.zeros(self._masses.size)
        self.speed = np.zeros(self._masses.size)
        self.speed[1::2] = speed
        self.heights = 2 * body.surface + 1
        extra = np.zeros(self._masses.size)
        extra[self.heights] = penalty
        shares = sum(share for share, *_ in self._arms)
        scale = diags(1 / np.sqrt(self._masses))
        stiffest = scale @ (self._elastic + shares * self._shear + diags(extra)) @ scale
        # A fixed start: the same touch gives the same bytes.
        start = np.random.default_rng(0).standard_normal(extra.size)
        fastest = eigsh(stiffest, 1, v0=start, return_eigenvectors=False, tol=1e-2)
        self.stable_step = 2 / math.sqrt(float(fastest[0]))

    def forces(self) -> Values:
        """Return the forces of the elements on the nodes, N."""
        return np.asarray(-(self._matrix @ self._state))

    def advance(self, forces: Values, dt: float) -> None:
        self.speed += dt * forces / self._masses
        self._moved += dt * self.speed
        np.multiply(self.speed, CALMING * dt, out=self.ahead)
        self.ahead += self._moved
        self._relaxing[:] = 0.0
        for share, relaxation, arm in self._arms:
            keep = math.exp(-dt / relaxation)
            arm *= keep
            arm += (1 - keep) * relaxation * self.speed
            self._relaxing += share * arm

    def energy(self, dt: float) -> float:
        """Return the kinetic and elastic energy in the middle of the last time step, J.

        ``dt`` is the length of the step, s.
        """
        moved = self._moved - dt / 2 * self.speed
        stored = moved @ (self._elastic @ moved) + self._masses @ self.speed**2
        relaxing = sum(share * (arm @ (self._shear @ arm)) for share, _, arm in self._arms)
        return float(stored + relaxing) / 2


def touch(
    finger: FingerParameters,
    body: Body,
    pad: Body | None = None,
    duration: float = DURATION,
    step: float = 1.0,
) -> Touch:
    """Simulate how a finger touches a free body. Return force and voltage over time.

    Parameters
    ----------
    finger
        Finger of the twin. If ``pad`` is given, the pad's numbers are those of all dimples
        together, and the skin has no mass of its own.
    body
        Body that is touched.
    pad
        Pad with a flat face, which gets the curvature of the tip. None stands for a rigid tip.
    duration
        Time after the contact, s.
    step
        Size of the steps, as a share of the usual one.
    """
    meeting = body if pad is None else pad
    radii, near = meeting.nodes[meeting.surface, 0], body.nodes[body.surface]
    # Linear weights of the body's nodes at the points of contact.
    weights = np.stack([np.interp(radii, near[:, 0], row) for row in np.eye(len(near))], 1)
    outline = finger.tip_radius - np.sqrt(np.maximum(finger.tip_radius**2 - radii**2, 0.0))
    gap = outline + weights @ near[:, 1]
    bodies = [body] if pad is None else [body, pad]
    penalty = 2 * min(each.material.wave_modulus / each.size for each in bodies) * meeting.areas
    target = motion = _Motion(body, weights.T @ penalty, 0.0)
    dt = target.stable_step
    if pad is not None:
        # Two nodes that move against each other feel twice the penalty.
        target = _Motion(body, 2 * weights.T @ penalty, 0.0)
        motion = _Motion(pad, 2 * penalty, -finger.speed)
        dt = min(target.stable_step, motion.stable_step)
    dt *= SAFETY * step
    every = max(round(INTERVAL / dt), 1)
    chain, skin, skin_v = _Chain(finger, dt), 0.0, finger.speed
    back, shares = (np.zeros(0, np.int64), np.ones(1)) if pad is None else pad.back()
    law = _Pad(finger, shares, dt)
    rows = []
    for number in range(1, math.ceil(duration / dt) + every):
        height = skin if pad is None else -motion.ahead[motion.heights]
        depth = np.maximum(height - gap - weights @ target.ahead[target.heights], 0.0)
        pressed = penalty * depth
        force = float(pressed.sum())
        loads = target.forces()
        loads[target.heights] += weights.T @ pressed
        target.advance(loads, dt)
        if pad is None:
            held = law.forces(np.array([chain.board - skin]), np.array([chain.board_v - skin_v]))
            skin_v += dt * (float(held[0]) - force) / finger.skin_mass
            skin += dt * skin_v
        else:  # the pad's displacements are counted against the finger's motion
            held = law.forces(chain.board + motion.ahead[back], chain.board_v + motion.speed[back])
            loads = motion.forces()
            loads[motion.heights] += pressed
            loads[back] -= held
            motion.advance(loads, dt)
        chain.advance(float(held.sum()))
        if number % every == 0:
            energy = target.energy(dt) + (pressed @ depth + finger.skin_mass * skin_v**2) / 2
            face = target.ahead[target.heights[0]]
            rows.append((number * dt, chain.volts, force, face, energy))
    return Touch(*np.array(rows).T)
