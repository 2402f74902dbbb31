"""Mechanics of a pinch, integrated with a fixed fine step.

Each finger is a chain drive - link - phalanx - mount - board - pad - skin. The skin meets a face of
the object (Hertz contact with a Maxwell arm and Hunt-Crossley loss). The two faces are joined by
the bulk and held by a clamp. The force through the mount drives the piezo disc. All motion is along
the closing direction.

The contact times are given, not the distances from the fingers to the object. A finger has no
effect before it touches. So each face of the object is placed where the finger of that face is at
the given time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from firstcontact.core import contact_modulus, hertz_stiffness, kernels
from firstcontact.twin._compiled import compiled, inlined
from firstcontact.twin._parameters import FingerParameters, ObjectParameters

#: States of a finger: position and speed of drive, phalanx, board and skin; elongation of the
#: Maxwell arms of pad and contact; voltage that the piezo has lost by leakage; buffer's output.
FINGER_STATES = 12
#: Two fingers, then position and speed of the object's two faces.
STATES = 2 * FINGER_STATES + 4
#: Number of values that :func:`integrate` writes per sample and finger.
OUTPUTS = 5
BUFFER, CONTACT_FORCE, INDENTATION, FACE, DRIVE_SPEED = range(OUTPUTS)
#: Distance below which a finger is about to touch, m.
NEAR = 2e-4

_Vector = NDArray[np.float64]
#: Arguments of :func:`integrate`.
Piece = tuple[Any, ...]
# Products with reciprocals replace divisions by parameters. The compiler moves them out of the
# loop, which saves a third of the time. The kernel ``core/c/mechanics.c`` gives the same bits.


def contact_stiffness(p: FingerParameters, o: ObjectParameters) -> float:
    """Return the Hertz stiffness of the finger against the object, N/m^1.5."""
    radius = 1 / (1 / p.tip_radius + 1 / o.radius)
    return hertz_stiffness(contact_modulus(p.pad_modulus, o.modulus), radius)


@inlined
def _contact_force(
    o: ObjectParameters, stiffness: float, depth: float, rate: float, arm: float
) -> float:
    """Return the force of a contact, N. ``depth`` is NaN before a finger touches."""
    if not depth >= 0.0:
        return 0.0
    slow = stiffness * depth * math.sqrt(depth) * (1.0 + 1.5 * o.contact_loss * rate)
    # A contact never pulls, even if the face recovers more slowly than the finger leaves.
    pressed = max(arm, 0.0)
    return max(slow + o.arm_share * stiffness * pressed * math.sqrt(pressed), 0.0)


@inlined
def _finger(
    x: _Vector, dx: _Vector, b: int, p: FingerParameters, o: ObjectParameters, stiffness: float,
    depth: float, rate: float, push: float, speed: float, motor_force: float, back_damping: float,
) -> float:  # fmt: skip
    """Compute the derivatives of one finger, and return its contact force, N.

    The finger's states begin at ``x[b]``, and their derivatives at ``dx[b]``.
    """
    drive, phalanx, board, skin = x[b], x[b + 2], x[b + 4], x[b + 6]
    drive_v, phalanx_v, board_v, skin_v = x[b + 1], x[b + 3], x[b + 5], x[b + 7]
    pad_arm, arm, leaked, buffer = x[b + 8], x[b + 9], x[b + 10], x[b + 11]
    motor = p.speed_gain * (speed - drive_v)
    motor = min(max(motor, -p.drive_force), motor_force)
    if back_damping > 0.0 and drive_v < 0.0 and speed >= 0.0:
        motor -= back_damping * drive_v  # pushed backwards while it should close or stand still
    link = p.link_stiffness * (drive - phalanx) + p.link_damping * (drive_v - phalanx_v)
    mount = p.mount_stiffness * (phalanx - board) + p.mount_damping * (phalanx_v - board_v)
    squeeze = board - skin
    squeezing = board_v - skin_v
    pad = (
        (p.pad_stiffness + p.pad_stiffening * squeeze * squeeze) * squeeze
        + p.pad_arm_stiffness * pad_arm
        + p.pad_damping * squeezing
    )
    force = _contact_force(o, stiffness, depth, rate, arm)
    arm_v = -arm * (1.0 / o.arm_relaxation)
    if depth >= 0.0:
        arm_v += rate
    volts = p.piezo_volts_per_newton * mount - leaked
    dx[b] = drive_v
    dx[b + 1] = (motor - link) * (1.0 / p.drive_mass)
    dx[b + 2] = phalanx_v
    dx[b + 3] = (link - mount + push) * (1.0 / p.phalanx_mass)
    dx[b + 4] = board_v
    dx[b + 5] = (mount - pad) * (1.0 / p.board_mass)
    dx[b + 6] = skin_v
    dx[b + 7] = (pad - force) * (1.0 / p.skin_mass)
    dx[b + 8] = squeezing - pad_arm * (1.0 / p.pad_relaxation)
    dx[b + 9] = arm_v
    dx[b + 10] = volts * (1.0 / p.piezo_time_constant)
    dx[b + 11] = 2.0 * math.pi * p.buffer_cutoff * (p.gain * volts - buffer)
    return force


@inlined
def _derivative(
    x: _Vector, dx: _Vector, index: FingerParameters, thumb: FingerParameters,
    o: ObjectParameters, stiffness: _Vector, gap: _Vector, push_i: float, push_t: float,
    speeds: _Vector, motor_force: float, back_damping: float,
) -> None:  # fmt: skip
    """Compute the derivatives ``dx`` of the state ``x``. ``gap`` is NaN before a finger touches."""
    n = 2 * FINGER_STATES
    f_i = _finger(
        x, dx, 0, index, o, stiffness[0], x[6] - x[n] - gap[0], x[7] - x[n + 1], push_i,
        speeds[0], motor_force, back_damping,
    )  # fmt: skip
    f_t = _finger(
        x, dx, 12, thumb, o, stiffness[1], x[18] + x[n + 2] - gap[1], x[19] + x[n + 3],
        push_t, speeds[1], motor_force, back_damping,
    )  # fmt: skip
    bulk = o.bulk_stiffness * (x[n] - x[n + 2]) + o.bulk_damping * (x[n + 1] - x[n + 3])
    dx[n] = x[n + 1]
    dx[n + 1] = (f_i - bulk - 0.5 * (o.clamp_stiffness * x[n] + o.clamp_damping * x[n + 1])) * (
        1.0 / o.face_mass
    )
    dx[n + 2] = x[n + 3]
    dx[n + 3] = (bulk - f_t - 0.5 * (o.clamp_stiffness * x[n + 2] + o.clamp_damping * x[n + 3])) * (
        1.0 / o.face_mass
    )


@inlined
def _step(
    x: _Vector, k: _Vector, t: float, dt: float, index: FingerParameters,
    thumb: FingerParameters, o: ObjectParameters, stiffness: _Vector, gap: _Vector,
    noise: _Vector, noise_dt: float, loudness: float, speeds: _Vector, motor_force: float,
    back_damping: float,
) -> None:  # fmt: skip
    """Advance ``x`` in place by one classical Runge-Kutta step."""
    for stage in range(4):
        h = 0.0 if stage == 0 else (dt if stage == 3 else 0.5 * dt)
        for j in range(STATES):
            k[4, j] = x[j] if stage == 0 else x[j] + h * k[stage - 1, j]
        place = (t + h) * (1.0 / noise_dt)
        cell = min(max(int(place), 0), noise.shape[1] - 2)
        part = place - cell
        _derivative(
            k[4], k[stage], index, thumb, o, stiffness, gap,
            loudness * (noise[0, cell] + part * (noise[0, cell + 1] - noise[0, cell])),
            loudness * (noise[1, cell] + part * (noise[1, cell + 1] - noise[1, cell])),
            speeds, motor_force, back_damping,
        )  # fmt: skip
    for j in range(STATES):
        x[j] += dt * (1.0 / 6.0) * (k[0, j] + 2.0 * (k[1, j] + k[2, j]) + k[3, j])


@compiled
def integrate(
    index: FingerParameters,
    thumb: FingerParameters,
    o: ObjectParameters,
    stiffness: _Vector,
    touch: _Vector,
    times: _Vector,
    noise: _Vector,
    noise_dt: float,
    substeps: int,
    speeds: _Vector,
    motor_force: float,
    back_damping: float,
    full_speed: float,
    limit: float,
    calm: float,
    calm_steps: int,
    x: _Vector,
    gap: _Vector,
    touched: _Vector,
    out: _Vector,
) -> int:
    """Integrate a pinch, or a piece of one.

    ``x``, ``gap`` and ``touched`` hold the complete state for the next piece, which starts at
    ``times[-1]``.

    Parameters
    ----------
    index, thumb, o
        The two fingers and the object.
    stiffness
        :func:`contact_stiffness` of each finger, shape (2,).
    touch
        Contact times of index and thumb, s. A finger whose time is after the end never touches.
    times
        Sampling instants, s, increasing. The state starts at ``times[0]``.
    noise
        Noise force on each phalanx, N, shape (2, points), from t = 0.
    noise_dt
        Time between two points of the noise, s.
    substeps
        Integration steps per sampling interval once a finger is about to touch. Half as many steps
        are used before.
    speeds
        Reference speeds of both drives in each sampling interval, m/s, shape (samples - 1, 2). One
        row if there is one sample.
    motor_force
        Largest force of each motor, N.
    back_damping
        Damping of a drive that is pushed backwards while it should close or stand still, N s/m.
    full_speed
        Drive speed at which motor noise has its full strength, m/s. Below this speed the noise is
        proportional to the speed. 0 means full strength at any speed.
    limit
        Contact force at which the object breaks, N. The integration stops at the first sample with
        a larger force.
    calm
        Time from the second contact until fewer steps are enough, s.
    calm_steps
        Integration steps per sampling interval after that time.
    x
        State at ``times[0]``, shape (28,), changed in place to the state at ``times[-1]``.
    gap
        Positions of the object's faces when index and thumb touched, m, shape (2,), changed in
        place. NaN before a contact: then ``touch`` decides when the finger touches. A number before
        a contact fixes the position of the face: then the finger touches when it gets there.
    touched
        First sampling instants at which index and thumb touched, s, shape (2,); NaN before. Changed
        in place.
    out
        Output, shape (samples, 2, 5): voltage of the buffer (V), contact force (N), indentation
        (m), displacement of the face (m), drive speed (m/s). The indentation is negative without
        contact, and NaN while the position of the face is unknown.

    Returns
    -------
    int
        Number of samples computed; ``times.size`` if the object did not break.
    """
    k = np.empty((5, STATES))
    n = 2 * FINGER_STATES
    first = 0 if touch[0] <= touch[1] else 1
    for sample in range(times.size):
        wanted = speeds[min(sample, len(speeds) - 1)]
        row = out[sample]
        row[0, INDENTATION] = x[6] - x[n] - gap[0]
        row[1, INDENTATION] = x[18] + x[n + 2] - gap[1]
        f_i = _contact_force(o, stiffness[0], row[0, INDENTATION], x[7] - x[n + 1], x[9])
        f_t = _contact_force(o, stiffness[1], row[1, INDENTATION], x[19] + x[n + 3], x[21])
        row[0, CONTACT_FORCE], row[1, CONTACT_FORCE] = f_i, f_t
        row[0, FACE], row[1, FACE] = x[n], -x[n + 2]
        near = times[min(sample + 1, times.size - 1)] >= touch[first]
        for f in range(2):
            row[f, BUFFER] = x[f * FINGER_STATES + 11]
            row[f, DRIVE_SPEED] = x[f * FINGER_STATES + 1]
            if row[f, INDENTATION] > 0.0 and math.isnan(touched[f]):
                touched[f] = times[sample]
            near = near or row[f, INDENTATION] > -NEAR
        if max(f_i, f_t) > limit:
            return sample + 1
        if sample == times.size - 1:
            break
        steps = substeps
        both = not math.isnan(touched[0] + touched[1])
        if both and times[sample] - max(touched[0], touched[1]) > calm:
            steps = calm_steps
        elif not near:
            steps = max(substeps // 2, 1)
        moving = 0.5 * (row[0, DRIVE_SPEED] + row[1, DRIVE_SPEED])
        loudness = 1.0 if full_speed <= 0.0 else min(abs(moving) * (1.0 / full_speed), 1.0)
        interval = times[sample + 1] - times[sample]
        for s in range(steps):
            t = times[sample] + interval * s * (1.0 / steps)
            end = times[sample] + interval * (s + 1) * (1.0 / steps)
            # Split a step at the instant of a contact.
            for _ in range(3):
                stop, touching = end, -1
                for f in (1 - first, first):
                    if math.isnan(gap[f]) and touch[f] < end:
                        stop, touching = max(touch[f], t), f
                _step(
                    x, k, t, stop - t, index, thumb, o, stiffness, gap, noise, noise_dt, loudness,
                    wanted, motor_force, back_damping,
                )  # fmt: skip
                if touching < 0:
                    break
                gap[touching] = x[6] - x[n] if touching == 0 else x[18] + x[n + 2]
                t = stop
    return int(times.size)


def integrate_all(pieces: list[Piece]) -> list[int]:
    """Integrate pieces of different pinches.

    The compiled kernels integrate them side by side, in the lanes of a vector unit.

    Parameters
    ----------
    pieces
        Arguments of :func:`integrate` for each piece.

    Returns
    -------
    list
        Number of samples computed of each piece.
    """
    module = kernels()
    if module is None:
        return [integrate(*piece) for piece in pieces]
    taken: list[int] = module.integrate_all(pieces)
    return taken
