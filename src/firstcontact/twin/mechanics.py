"""The mechanics of a pinch, integrated with a fixed fine step.

Each finger is a chain drive - link - phalanx - mount - board - pad - skin; the
skin meets a face of the object (Hertz with a Maxwell arm and Hunt-Crossley
loss); the two faces are joined by the bulk and held by a clamp. The piezo disc
is driven by the force through the mount. All of it along the closing axis.

The offset between the contacts is given, not the gap: a finger that has not
touched acts on nothing, so the gap that makes it touch at the wanted instant is
read off its own free motion when that instant comes.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from firstcontact.twin.parameters import FingerParameters, ObjectParameters

#: States of a finger: positions and speeds of drive, phalanx, board and skin,
#: the Maxwell arms of pad and contact, the piezo's leaked voltage, the buffer.
FINGER_STATES = 12
#: Two fingers, then position and speed of the object's two faces.
STATES = 2 * FINGER_STATES + 4
#: What :func:`integrate` writes per sample and finger.
OUTPUTS = 4
BUFFER, MOUNT_FORCE, CONTACT_FORCE, INDENTATION = range(OUTPUTS)

_Vector = NDArray[np.float64]
_njit = njit(cache=True, nogil=True, error_model="numpy")


@_njit
def contact_stiffness(p: FingerParameters, o: ObjectParameters) -> float:
    """K of the finger against the object, N/m^1.5."""
    modulus = 1.0 / (0.7599 / p.pad_modulus + 0.7599 / o.modulus)
    radius = 1.0 / (1.0 / p.tip_radius + 1.0 / o.radius)
    return 4.0 / 3.0 * modulus * math.sqrt(radius)


@_njit
def _finger(
    x: _Vector, dx: _Vector, b: int, p: FingerParameters, o: ObjectParameters, stiffness: float,
    touching: bool, depth: float, rate: float, push: float,
) -> float:  # fmt: skip
    """Derivatives of one finger's states from ``b`` on; returns the contact force, N."""
    motor = p.speed_gain * (p.speed - x[b + 1])
    motor = min(max(motor, -p.drive_force), p.drive_force)
    link = p.link_stiffness * (x[b] - x[b + 2]) + p.link_damping * (x[b + 1] - x[b + 3])
    mount = p.mount_stiffness * (x[b + 2] - x[b + 4]) + p.mount_damping * (x[b + 3] - x[b + 5])
    squeeze = x[b + 4] - x[b + 6]
    squeezing = x[b + 5] - x[b + 7]
    pad = (
        (p.pad_stiffness + p.pad_stiffening * squeeze * squeeze) * squeeze
        + p.pad_arm_stiffness * x[b + 8]
        + p.pad_damping * squeezing
    )
    force = 0.0
    dx[b + 9] = -x[b + 9] / o.arm_relaxation
    if touching and depth > 0.0:
        dx[b + 9] += rate
        slow = stiffness * depth * math.sqrt(depth) * (1.0 + 1.5 * o.contact_loss * rate)
        arm = max(x[b + 9], 0.0)
        force = max(slow + o.arm_share * stiffness * arm * math.sqrt(arm), 0.0)
    dx[b] = x[b + 1]
    dx[b + 1] = (motor - link) / p.drive_mass
    dx[b + 2] = x[b + 3]
    dx[b + 3] = (link - mount + push) / p.phalanx_mass
    dx[b + 4] = x[b + 5]
    dx[b + 5] = (mount - pad) / p.board_mass
    dx[b + 6] = x[b + 7]
    dx[b + 7] = (pad - force) / p.skin_mass
    dx[b + 8] = squeezing - x[b + 8] / p.pad_relaxation
    volts = p.piezo_volts_per_newton * mount - x[b + 10]
    dx[b + 10] = volts / p.piezo_time_constant
    dx[b + 11] = 2.0 * math.pi * p.buffer_cutoff * (p.gain * volts - x[b + 11])
    return force


@_njit
def _derivative(
    x: _Vector, dx: _Vector, index: FingerParameters, thumb: FingerParameters,
    o: ObjectParameters, stiffness: _Vector, gap: _Vector, push_i: float, push_t: float,
) -> tuple[float, float]:  # fmt: skip
    """All derivatives. ``gap`` is NaN for a finger that has not touched yet."""
    n = 2 * FINGER_STATES
    on_i = not math.isnan(gap[0])
    on_t = not math.isnan(gap[1])
    f_i = _finger(
        x, dx, 0, index, o, stiffness[0], on_i, x[6] - gap[0] - x[n], x[7] - x[n + 1], push_i
    )
    f_t = _finger(
        x, dx, 12, thumb, o, stiffness[1], on_t, x[18] - gap[1] + x[n + 2], x[19] + x[n + 3], push_t
    )
    bulk = o.bulk_stiffness * (x[n] - x[n + 2]) + o.bulk_damping * (x[n + 1] - x[n + 3])
    dx[n] = x[n + 1]
    dx[n + 1] = (
        f_i - bulk - 0.5 * (o.clamp_stiffness * x[n] + o.clamp_damping * x[n + 1])
    ) / o.face_mass
    dx[n + 2] = x[n + 3]
    dx[n + 3] = (
        bulk - f_t - 0.5 * (o.clamp_stiffness * x[n + 2] + o.clamp_damping * x[n + 3])
    ) / o.face_mass
    return f_i, f_t


@_njit
def _step(
    x: _Vector, new: _Vector, k: _Vector, t: float, dt: float, index: FingerParameters,
    thumb: FingerParameters, o: ObjectParameters, stiffness: _Vector, gap: _Vector,
    noise: _Vector, noise_dt: float,
) -> None:  # fmt: skip
    """One classical Runge-Kutta step from ``x`` to ``new``."""
    for stage in range(4):
        h = 0.0 if stage == 0 else (dt if stage == 3 else 0.5 * dt)
        if stage == 0:
            k[4, :] = x
        else:
            for j in range(STATES):
                k[4, j] = x[j] + h * k[stage - 1, j]
        place = (t + h) / noise_dt
        cell = min(max(int(place), 0), noise.shape[1] - 2)
        part = place - cell
        _derivative(
            k[4], k[stage], index, thumb, o, stiffness, gap,
            noise[0, cell] + part * (noise[0, cell + 1] - noise[0, cell]),
            noise[1, cell] + part * (noise[1, cell + 1] - noise[1, cell]),
        )  # fmt: skip
    for j in range(STATES):
        new[j] = x[j] + dt / 6.0 * (k[0, j] + 2.0 * (k[1, j] + k[2, j]) + k[3, j])


@_njit
def integrate(
    index: FingerParameters,
    thumb: FingerParameters,
    o: ObjectParameters,
    touch: _Vector,
    times: _Vector,
    noise: _Vector,
    noise_dt: float,
    substeps: int,
    x: _Vector,
    out: _Vector,
) -> None:
    """Run a pinch.

    Parameters
    ----------
    index, thumb, o
        The two fingers and the object.
    touch
        Instants at which index and thumb touch, s; beyond the end for never.
    times
        Sampling instants, s, increasing; ``times[0]`` is where the state starts.
    noise
        Force on each phalanx, N, shape (2, points), ``noise_dt`` apart from t = 0.
    substeps
        Steps per sampling interval once a finger has touched; half as many before.
    x
        State at ``times[0]``, shape (28,), changed in place.
    out
        Shape (samples, 2, 4): buffer (V), force through the mount (N), contact
        force (N), indentation (m; negative while apart, NaN before the contact).
    """
    stiffness = np.empty(2)
    stiffness[0] = contact_stiffness(index, o)
    stiffness[1] = contact_stiffness(thumb, o)
    gap = np.full(2, np.nan)
    new = np.empty(STATES)
    k = np.empty((5, STATES))
    n = 2 * FINGER_STATES
    for sample in range(times.size):
        f_i, f_t = _derivative(x, k[0], index, thumb, o, stiffness, gap, 0.0, 0.0)
        out[sample, 0, CONTACT_FORCE] = f_i
        out[sample, 1, CONTACT_FORCE] = f_t
        out[sample, 0, INDENTATION] = x[6] - gap[0] - x[n]
        out[sample, 1, INDENTATION] = x[18] - gap[1] + x[n + 2]
        for f in range(2):
            p = index if f == 0 else thumb
            b = f * FINGER_STATES
            out[sample, f, BUFFER] = x[b + 11]
            out[sample, f, MOUNT_FORCE] = p.mount_stiffness * (
                x[b + 2] - x[b + 4]
            ) + p.mount_damping * (x[b + 3] - x[b + 5])
        if sample == times.size - 1:
            break
        interval = times[sample + 1] - times[sample]
        near = times[sample + 1] >= min(touch[0], touch[1])
        steps = substeps if near else max(substeps // 2, 1)
        dt = interval / steps
        for s in range(steps):
            t = times[sample] + s * dt
            # A finger that touches within this step: step freely, read where it
            # is at that instant (cubic through both ends), then step again.
            for f in range(2):
                if math.isnan(gap[f]) and touch[f] < t + dt:
                    _step(x, new, k, t, dt, index, thumb, o, stiffness, gap, noise, noise_dt)
                    a = max((touch[f] - t) / dt, 0.0)
                    skin = FINGER_STATES * f + 6
                    face = n + 2 * f
                    gap[f] = _hermite(x[skin], x[skin + 1], new[skin], new[skin + 1], a, dt)
                    at = _hermite(x[face], x[face + 1], new[face], new[face + 1], a, dt)
                    gap[f] += -at if f == 0 else at
            _step(x, new, k, t, dt, index, thumb, o, stiffness, gap, noise, noise_dt)
            x[:] = new


@_njit
def _hermite(x0: float, v0: float, x1: float, v1: float, a: float, dt: float) -> float:
    """Position a share ``a`` into a step, from positions and speeds at its ends."""
    return (
        (1.0 + 2.0 * a) * (1.0 - a) ** 2 * x0
        + a * (1.0 - a) ** 2 * dt * v0
        + a * a * (3.0 - 2.0 * a) * x1
        + a * a * (a - 1.0) * dt * v1
    )
