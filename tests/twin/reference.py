"""Reference of the twin's compiled loops, in plain Python: slow and short.

Functions have the names and arguments of the compiled ones. Other tests check the
device's filters, the slide and the band-pass.
"""

import math
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from firstcontact.core.layout import (
    ADC_COUNTS,
    ADC_VOLTS,
    FINGERTIP_RATE,
    PIEZO_OFFSET_VOLTS,
    TAXELS,
)
from firstcontact.twin.mechanics import (
    DRIVE_SPEED,
    FINGER_STATES,
    INDENTATION,
    STATES,
    FingerParameters,
    ObjectParameters,
    Piece,
    VelostatParameters,
)
from firstcontact.twin.slip_sound import PLACES, SlipParameters

#: Distance below which a finger is about to touch, m.
NEAR = 2e-4
#: Steps per sampling interval of a sliding pad.
SLIP_STEPS = 20

Array = NDArray[Any]


class Touching(NamedTuple):
    """State of a contact: depth, force, and rate at which its Maxwell arms grow."""

    depth: float
    force: float
    growth: float


def hertz(depth: float, b: float) -> float:
    """Return Hertz's force over its stiffness. ``b`` is the confinement by a rigid back."""
    e = b * depth**0.5
    return float(depth**1.5) * (1 + 1.5 * e + 2.6 * e**2 + 5 * e**3)


def touching(
    f: FingerParameters, o: ObjectParameters, stiffness: float, depth: float, rate: float,
    fast: float, slow: float,
) -> Touching:  # fmt: skip
    """Return the state of a contact. ``depth`` is NaN before a finger touches."""
    b, dent = f.pad_confinement * stiffness, stiffness / o.dent_stiffness
    arms = o.arm_share * fast + o.slow_share * slow
    fading = o.arm_share * fast / o.arm_relaxation + o.slow_share * slow / o.slow_relaxation
    everything = 1 + o.arm_share + o.slow_share
    # Off the finger, the face recovers by itself.
    off = Touching(depth, 0.0, fading / everything)
    if not depth >= 0:
        return off
    left = max(depth - dent * arms, 0.0)
    pressed = left
    if dent > 0 and left > 0:
        pressed = brentq(lambda d: d + dent * hertz(d, b) - left, 0.0, left, xtol=1e-18)
    force = stiffness * (hertz(pressed, b) + arms)
    e = b * pressed**0.5
    slope = pressed**0.5 * (1.5 + 3 * e + 6.5 * e**2 + 15 * e**3)
    growth = slope * (rate + dent * fading) / (1 + dent * slope * everything)
    return Touching(depth, force, growth) if force > 0 else off


def contacts(x: Array, p: Piece) -> list[Touching]:
    """Return the state of both contacts."""
    # Position and speed of the faces along the fingers' motion.
    faces = ((x[26], x[27]), (-x[28], -x[29]))
    states = []
    for f, (face, face_speed) in enumerate(faces):
        finger = x[f * FINGER_STATES :]
        depth, rate = finger[6] - face - p.gap[f], finger[7] - face_speed
        arms = finger[9], finger[10]
        states.append(touching(p[f], p.target, p.stiffness[f], depth, rate, *arms))
    return states


def finger_derivative(
    x: Array, f: FingerParameters, push: float, speed: float, p: Piece,
    contact: Touching, o: ObjectParameters,
) -> list[float]:  # fmt: skip
    """Return the derivatives of one finger's states."""
    drive, drive_v, phalanx, phalanx_v, board, board_v, skin, skin_v = x[:8]
    pad_arm, fast, slow, leaked, buffer = x[8:13]
    motor = min(max(f.speed_gain * (speed - drive_v), -f.drive_force), p.motor_force)
    if drive_v < 0 <= speed:
        motor -= p.back_damping * drive_v  # pushed back while it should close or stand still
    link = f.link_stiffness * (drive - phalanx) + f.link_damping * (drive_v - phalanx_v)
    mount = f.mount_stiffness * (phalanx - board) + f.mount_damping * (phalanx_v - board_v)
    squeeze, squeezing = board - skin, board_v - skin_v
    pad = (f.pad_stiffness + f.pad_stiffening * squeeze**2) * squeeze
    pad += f.pad_arm_stiffness * pad_arm + f.pad_damping * squeezing
    volts = f.piezo_volts_per_newton * mount - leaked
    return [
        drive_v,
        (motor - link) / f.drive_mass,
        phalanx_v,
        (link - mount + push) / f.phalanx_mass,
        board_v,
        (mount - pad) / f.board_mass,
        skin_v,
        (pad - contact.force) / f.skin_mass,
        squeezing - pad_arm / f.pad_relaxation,
        contact.growth - fast / o.arm_relaxation,
        contact.growth - slow / o.slow_relaxation,
        volts / f.piezo_time_constant,
        2 * math.pi * f.buffer_cutoff * (f.gain * volts - buffer),
    ]


def derivative(x: Array, p: Piece, push: Array, speeds: Array) -> Array:
    """Return the derivatives of the state ``x`` under noise forces and reference speeds."""
    o, both = p.target, contacts(x, p)
    dx = []
    for f, finger in enumerate((p.index_finger, p.thumb)):
        states = x[f * FINGER_STATES : (f + 1) * FINGER_STATES]
        dx += finger_derivative(states, finger, push[f], speeds[f], p, both[f], o)
    bulk = o.bulk_stiffness * (x[26] - x[28]) + o.bulk_damping * (x[27] - x[29])
    outer = [both[0].force - bulk, bulk - both[1].force]
    for place, force in zip((26, 28), outer, strict=True):
        clamp = (o.clamp_stiffness * x[place] + o.clamp_damping * x[place + 1]) / 2
        dx += [x[place + 1], (force - clamp) / o.face_mass]
    return np.array(dx)


def advance(p: Piece, t: float, dt: float, loudness: float, speeds: Array) -> None:
    """Advance ``p.x`` by one classical Runge-Kutta step."""
    grid = np.arange(p.noise.shape[1]) * p.noise_dt
    k = np.zeros((5, STATES))
    for stage, h in enumerate((0.0, dt / 2, dt / 2, dt)):
        push = loudness * np.array([np.interp(t + h, grid, line) for line in p.noise])
        k[stage] = derivative(p.x + h * k[stage - 1], p, push, speeds)
    p.x[:] += dt / 6 * (k[0] + 2 * (k[1] + k[2]) + k[3])


def integrate(p: Piece) -> int:
    """Integrate a piece. Return the number of samples computed."""
    first = 0 if p.touch[0] <= p.touch[1] else 1
    for sample, time in enumerate(p.times):
        both = contacts(p.x, p)
        for f, (depth, force, _) in enumerate(both):
            x = p.x[f * FINGER_STATES :]
            p.out[sample, f] = x[12], force, depth, (p.x[26], -p.x[28])[f], x[1]
            if depth > 0 and math.isnan(p.touched[f]):
                p.touched[f] = time
        if max(contact.force for contact in both) > p.limit:
            return sample + 1
        if sample == p.times.size - 1:
            break
        following = p.times[sample + 1]
        near = following >= p.touch[first] or (p.out[sample, :, INDENTATION] > -NEAR).any()
        if time - p.touched.max() > p.calm:  # NaN before the second contact
            steps = p.calm_steps
        else:
            steps = p.substeps if near else max(p.substeps // 2, 1)
        moving = abs(p.out[sample, :, DRIVE_SPEED].mean())
        loudness = min(moving / p.full_speed, 1.0) if p.full_speed > 0 else 1.0
        edges = time + (following - time) * np.arange(steps + 1) / steps
        for t, end in pairwise(edges):
            # Split a step at the instant of a contact.
            wanted = p.speeds[min(sample, len(p.speeds) - 1)]
            for f in (first, 1 - first):
                if math.isnan(p.gap[f]) and p.touch[f] < end:
                    stop = max(p.touch[f], t)
                    advance(p, t, stop - t, loudness, wanted)
                    p.gap[f] = p.x[6] - p.x[26] if f == 0 else p.x[19] + p.x[28]
                    t = stop
            advance(p, t, end - t, loudness, wanted)
    return len(p.times)


def tones(lines: Array, turns: Array, amplitudes: Array, depth: Array, out: Array) -> None:
    """Add spectral lines to ``out``: rotating phasors, whose last one modulates the others."""
    phasors = (lines * turns ** np.arange(out.size)[:, np.newaxis]).imag
    out += (amplitudes * (1 + depth * phasors[:, -1:]) * phasors[:, :-1]).sum(axis=1)
    lines *= turns**out.size


def adc_count(volts: float) -> int:
    """Return the ADC count of a voltage."""
    return min(max(math.floor(volts * (ADC_COUNTS / ADC_VOLTS)), 0), ADC_COUNTS - 1)


def piezo_counts(volts: Array, out: Array) -> None:
    """Write the ADC counts of a piezo's voltage."""
    out[:] = [adc_count(v + PIEZO_OFFSET_VOLTS) for v in volts]


def force_counts(
    force: Array, shares: Array, p: VelostatParameters, noise: Array, dt: float, state: Array,
    first: int, out: Array,
) -> None:  # fmt: skip
    """Write the readings of one force array."""
    quick, late = state
    for i in range(force.size):
        load = np.maximum(force[i] * shares - p.threshold, 0.0)
        quick += (load - quick) * dt / np.where(load > quick, p.rise, p.fall)
        late += (load - late) * dt / p.creep
        response = (1 - p.creep_share) * quick + p.creep_share * late
        conductance = p.leak + p.conductance * response**p.exponent
        row, column = divmod((first + i) % TAXELS, 2)
        # Kirchhoff's current law at three rows and two columns.
        g = conductance.reshape(3, 2)
        rows = np.diag(1 / p.row + g.sum(axis=1))
        columns = np.diag(1 / p.resistor + g.sum(axis=0))
        currents = np.zeros(5)
        currents[row] = ADC_VOLTS / p.row
        volts = np.linalg.solve(np.block([[rows, -g], [-g.T, columns]]), currents)
        out[i] = adc_count(volts[3 + column] + noise[i])


def slide_patches(
    normal: Array, speed: Array, pull: Array, mass: float, friction: float, p: SlipParameters,
    finger: FingerParameters, factors: Array, patches: Array, state: Array, out: Array,
) -> None:  # fmt: skip
    """Advance the patches of one finger's pad, and write the voltage of their sound."""
    dt = 1 / (FINGERTIP_RATE * SLIP_STEPS)
    k, m = p.stiffness / p.patches, p.mass / p.patches
    c = 2 * p.damping * math.sqrt(k * m)
    shear = 2 * p.stiffness / mass  # both pads hold the object
    loss = 2 * p.damping * math.sqrt(shear)
    volts_per_newton = p.coupling * finger.piezo_volts_per_newton
    leak = 1 - math.exp(-dt / finger.piezo_time_constant)
    open_buffer = 1 - math.exp(-2 * math.pi * finger.buffer_cutoff * dt)
    offset, velocity, sticking, path = patches.T  # views
    for i, new in enumerate(np.stack([normal, speed, pull], axis=1)):
        for step in range(SLIP_STEPS):
            press, slides, load = state[:3] + (step + 1) / SLIP_STEPS * (new - state[:3])
            if shear * dt * dt > 0.04:  # it swings faster than a step can follow
                state[4] = (load / p.stiffness - state[3]) / dt
                state[3] = load / p.stiffness
            else:
                state[4] += (shear * (load / p.stiffness - state[3]) - loss * state[4]) * dt
                state[3] += state[4] * dt
            surface = slides + state[4]
            place = path.astype(int)
            rows = np.arange(p.patches)
            left, right = factors[rows, place % PLACES], factors[rows, (place + 1) % PLACES]
            static = friction * (left + (path - place) * (right - left))
            static *= max(press, 0.0) / p.patches

            stuck = sticking > 0
            velocity[stuck] = surface
            offset[stuck] += surface * dt
            back = k * offset + c * velocity
            sticking[stuck & (np.abs(back) > static)] = 0.0

            moves = ~stuck
            off = surface - velocity
            kinetic = static / p.ratio
            drag = kinetic + (static - kinetic) * np.exp(-np.abs(off) / p.weakening)
            force = np.where(off > 0, drag, -drag) - back
            velocity[moves] += (force / m * dt)[moves]
            offset[moves] += (velocity * dt)[moves]
            path[moves] += (np.abs(off) * dt / p.grain)[moves]
            turned = off * (surface - velocity) <= 0
            caught = moves & turned & (np.abs(k * offset) <= static)
            sticking[caught], velocity[caught] = 1.0, surface

            pressed = volts_per_newton * back.sum()
            state[5] += leak * (pressed - state[5])
            state[6] += open_buffer * (finger.gain * (pressed - state[5]) - state[6])
        state[:3] = new
        state[3:][np.abs(state[3:]) < 1e-30] = 0.0
        out[i] = state[6]
